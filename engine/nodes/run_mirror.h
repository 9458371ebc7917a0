// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/nodes/graph_plan.h"

namespace plumbline {

class NodeClient;
class RunWriter;
class SocketContext;
class RunPoses;

/// A copy of the run that a graph's recorder writes, kept by whoever looks on from another machine:
/// a thread asks for the frames that have come, until the run has ended or somebody has stopped the
/// graph. Whatever dies there is waited for. The destructor stops and leaves the copy as far as it
/// came.
class RunMirror {
 public:
  /// Waits until the run has begun, and makes the copy.
  /// @param name  As whom it asks: of its key, where the graph has keys.
  /// Errors: kInvalidInput (a graph without recorder), those of keys, endpoints and
  /// RunWriter::Create; kCancelled.
  static Result<std::unique_ptr<RunMirror>> Start(const GraphPlan& plan, const std::string& name,
                                                  const std::filesystem::path& file,
                                                  const WorkContext& work);
  ~RunMirror();
  RunMirror(const RunMirror&) = delete;
  RunMirror& operator=(const RunMirror&) = delete;

 private:
  RunMirror();
  void Run(const std::stop_token& stop);
  Status Copy(const std::stop_token& stop);

  std::unique_ptr<NodeClient> recorder_, vio_;
  std::unique_ptr<RunPoses> poses_;
  std::unique_ptr<RunWriter> writer_;
  int num_models_ = 0;
  std::jthread thread_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
