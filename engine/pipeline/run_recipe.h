// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"
#include "engine/mapping/mapper_options.h"
#include "engine/vio/own_pose_options.h"

namespace plumbline {

/// Frames A:B:S of a sequence: from A, before B, every S-th.
struct FrameRange {
  int begin = 0;
  std::optional<int> end;
  int step = 1;
  bool operator==(const FrameRange&) const = default;
};

inline constexpr double kSlowestLive = 0.01, kFastestLive = 100;  ///< Of RunRecipe::live_speed.

/// Parses "A:B" or "A:B:S" (parts may be left out). Errors: kInvalidInput.
Result<FrameRange> ParseFrameRange(std::string_view text);

enum class PoseSource { kDataset, kVio, kTrajectory };
enum class EdgeSource { kDataset, kGradient, kBuiltin, kBuiltinHalf, kNetwork };
enum class DetectorSource { kDataset, kBuiltin, kNetwork };
enum class ScorerKind { kViewpoint, kRendered };

template <>
struct EnumNames<PoseSource> {
  static constexpr std::string_view names[] = {"dataset", "vio", "trajectory"};
};
template <>
struct EnumNames<EdgeSource> {
  static constexpr std::string_view names[] = {"dataset", "gradient", "builtin", "builtin-half",
                                               "network"};
};
template <>
struct EnumNames<DetectorSource> {
  static constexpr std::string_view names[] = {"dataset", "builtin", "network"};
};
template <>
struct EnumNames<ScorerKind> {
  static constexpr std::string_view names[] = {"viewpoint", "rendered"};
};

/// Where one input of a run comes from. `file` (a network, a trajectory) belongs to the last of the
/// sources; `hash` is that of its content (of poses from the filter: of its options; of a built-in
/// network: of its weights), known once it has been opened.
template <typename Source>
struct InputChoice {
  Source source{};
  std::filesystem::path file;
  std::string hash;

  /// Whether both give the same, wherever their files lie.
  bool SameContent(const InputChoice& other) const {
    return source == other.source && hash == other.hash;
  }
};
using PoseChoice = InputChoice<PoseSource>;
using EdgeChoice = InputChoice<EdgeSource>;
using DetectorChoice = InputChoice<DetectorSource>;

/// Everything that a run depends on, as data. MappingPipeline::Open makes a run from it; the run
/// file stores it, and resume, fork, probe, comparison and pictures start from what is stored.
struct RunRecipe {
  std::filesystem::path sequence;
  std::filesystem::path models;  ///< Empty: the sequence's own.
  PoseChoice poses;
  OwnPoseOptions own_poses;                ///< Of poses = vio.
  std::optional<DetectorChoice> detector;  ///< Nothing: DefaultDetector.
  std::optional<EdgeChoice> edges;         ///< Nothing: DefaultEdges.
  ScorerKind scorer = ScorerKind::kViewpoint;
  MapperOptions options;
  std::uint64_t seed = 0;
  FrameRange frames;
  /// The recording is played by the clock, this many times as fast as it was taken, and images that
  /// the mapper has no time for are passed over: such a run cannot be repeated. Nothing: every
  /// frame is mapped, however long it takes.
  std::optional<double> live_speed;
};

/// As the command line writes them: the name of a source, or the path of a file. A file that has
/// the name of a source is written with its folder ("./gradient").
PoseChoice ParsePoses(const std::string& text);
EdgeChoice ParseEdges(const std::string& text);
DetectorChoice ParseDetector(const std::string& text);
/// The reverse; CreateEdgeDetector and CreateDetector take it.
std::string ToText(const PoseChoice& choice);
std::string ToText(const EdgeChoice& choice);
std::string ToText(const DetectorChoice& choice);

std::string_view NameOf(ScorerKind kind);

/// Options as a file has them; with a warning in the log for each that this version does not know.
MapperOptions KnownOptions(const nlohmann::json& stored);

/// Content hash of the options that poses of the filter come from.
std::string HashOf(const OwnPoseOptions& options);

/// The sequence's own where it has any, else the built-in network.
EdgeChoice DefaultEdges(const Sequence& sequence);

/// The sequence's own proposals where it has any, else the best network that `plumbline networks
/// get` has fetched, else the built-in one.
DetectorChoice DefaultDetector(const Sequence& sequence);

/// {"version": 2, ..}, paths absolute.
nlohmann::json RecipeToJson(const RunRecipe& recipe);
/// Options that this version does not know are left out with a warning in the log. Errors:
/// kUnsupported for a recipe of a newer version, kCorrupt; with what is wrong but no file name.
Result<RunRecipe> RecipeFromJson(const nlohmann::json& json);

}  // namespace plumbline
