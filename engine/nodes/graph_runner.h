// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "engine/base/file_lock.h"
#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/nodes/graph_plan.h"

namespace plumbline {

struct GraphRunOptions {
  std::filesystem::path program;     ///< Ours, which the nodes are started with.
  std::filesystem::path graph_file;  ///< The resolved plan, for the nodes.
  /// Keeps color.csv of a recording locked (RecordingWriter::TakeLock) that camera and IMU of the
  /// graph write; given back when they have ended, which ends the recording for all who follow it.
  std::unique_ptr<FileLock> recording = {};
  /// Told of what happens, one line each, from several threads.
  std::function<void(const std::string&)> tell = [](const std::string&) {};
};

struct GraphRunEnd {
  std::map<std::string, int> restarts;  ///< Of nodes that died.
};

/// Starts the nodes of a resolved graph as processes, watches them, starts again what died, and
/// ends them in order, askers before those whom they ask, when the recorder has ended its run or
/// `work.stop` is requested. A node goes on where it was: the mapper from the last frame that the
/// recorder has, the recorder at the end of its file, camera and IMU at the end of the recording;
/// the others know nothing that is lost. A graph that records, and is asked to stop, ends its
/// recording first and maps what has come; so it does when its camera gives no more, or its time is
/// over. Errors: the sentence of a node that fails by itself again and again (what it says is in
/// NAME.log of the graph's folder); kIo where none can be started; kCancelled.
Result<GraphRunEnd> RunGraph(const GraphPlan& plan, GraphRunOptions options,
                             const WorkContext& work);

}  // namespace plumbline
