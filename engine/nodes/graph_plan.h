// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"
#include "engine/pipeline/run_recipe.h"

namespace plumbline {

/// What a node of ours does; others are programs of other people.
enum class NodeKind { kPlayer, kEdges, kDetector, kVio, kMapper, kRecorder, kCamera, kImu, kOther };

template <>
struct EnumNames<NodeKind> {
  static constexpr std::string_view names[] = {"player",   "edges",  "detector", "vio",  "mapper",
                                               "recorder", "camera", "imu",      "other"};
};
std::string_view NameOf(NodeKind kind);

/// One process of a graph. What it asks of others are their names; what is empty it does by itself
/// (a mapper without `edges` finds edges in its own process).
struct GraphNode {
  std::string name;
  NodeKind kind = NodeKind::kOther;
  std::string endpoint;  ///< Empty until ResolveGraph: a socket in the graph's own folder.
  std::string images, edges, proposals;  ///< Whom it asks for them.
  std::string reports;                   ///< The recorder: whom it records.
  std::string recorder;                  ///< The mapper: who knows where it stood.
  std::string poses;                     ///< Mapper and recorder: who found them (poses = vio).
  std::string source;  ///< Camera and IMU: what they read (CameraInput::spec, ReadImuInput).
  /// The program that is started, with {endpoint}, {images} (the endpoint of that node) and {name}
  /// replaced; empty: our own.
  std::vector<std::string> command;
  /// False: somebody starts it, on another machine perhaps.
  bool start = true;
};

/// How a graph with a camera records: into the folder of its recipe's sequence.
struct GraphRecording {
  std::int64_t began_ns = 0;  ///< Of this machine's steady clock; what is played again begins then.
  double seconds = 0;         ///< 0: until it is stopped, or nothing more comes.
  bool lossless = false;      ///< PNG instead of JPEG.
  std::optional<double> exposure_ms = {};  ///< Exposure::milliseconds.
};

/// Which parts of a run are processes of their own, and how they find one another.
struct GraphPlan {
  std::vector<GraphNode> nodes;
  std::filesystem::path keys;  ///< Folder of CURVE keys; empty: none are used.

  // What is run; `plumbline up` fills it in.
  std::optional<RunRecipe> recipe;
  std::filesystem::path out;  ///< Run file.
  bool resume = false;
  GraphRecording recording;      ///< Where a node is a camera.
  std::filesystem::path folder;  ///< Of sockets and logs, its own.

  /// Null where there is none.
  const GraphNode* Find(const std::string& name) const;
  const GraphNode* FirstOf(NodeKind kind) const;
};

/// Errors: kInvalidInput, kCorrupt, with what is wrong but no file name.
Result<GraphPlan> GraphFromJson(const nlohmann::json& json);
nlohmann::json GraphToJson(const GraphPlan& plan);
/// Errors: as above, naming the file; kNotFound, kIo.
Result<GraphPlan> ReadGraph(const std::filesystem::path& file);

/// Gives every node an endpoint. Errors: kInvalidInput where a name of a socket would be too long.
Status ResolveGraph(const std::filesystem::path& folder, GraphPlan& plan);

}  // namespace plumbline
