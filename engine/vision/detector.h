// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"
#include "engine/geometry/box.h"
#include "engine/vision/network_sidecar.h"

namespace plumbline {

/// What a detector sees in one image: its proposals (bottom-up), and its score for any box
/// (top-down), both from one pass over shared features. Immutable; safe to use from several
/// threads.
class FrameDetections {
 public:
  virtual ~FrameDetections() = default;
  /// After non-maximum suppression, by falling score.
  virtual std::span<const Detection> proposals() const = 0;
  /// Scores in [0, 1] of `boxes` as `category`, continuous in the box; 0 for a category that the
  /// detector does not know and for empty boxes. `scores` is as long as `boxes`.
  virtual void ScoreBoxes(std::string_view category, std::span<const Box2> boxes,
                          std::span<float> scores) const = 0;
};

/// Finds objects in images. Not safe to use from several threads at once.
class Detector {
 public:
  virtual ~Detector() = default;
  /// Errors: kCorrupt, kNotFound for what the frame lacks.
  virtual Result<std::unique_ptr<const FrameDetections>> Detect(const Frame& frame) = 0;
};

/// How the proposals of a network are chosen. Top-down scores do not depend on it.
struct DetectorOptions {
  float min_score = 0.1f;  ///< Proposals below are dropped, in [0, 1].
  float nms_iou =
      0.45f;  ///< Of two boxes of one category that overlap more, the better stays; in [0, 1].
  bool cache = true;  ///< Off: the network runs, whatever NetworkCache knows.
};

/// `dataset` (the sequence's proposals; a box scores the maximum over proposals of its category of
/// score * IoU), `builtin` (our two-stage network) or the path of an ONNX network with its sidecar.
/// Errors: kNotFound, kCorrupt, kInvalidInput, kUnsupported.
Result<std::unique_ptr<Detector>> CreateDetector(std::string_view choice,
                                                 std::shared_ptr<const Sequence> sequence,
                                                 const DetectorOptions& options = {});

/// Of a network of any kind but kEdge, with a sidecar that need not lie beside it. Errors: as
/// above.
Result<std::unique_ptr<Detector>> CreateNetworkDetector(const std::filesystem::path& onnx_file,
                                                        NetworkSidecar sidecar,
                                                        const DetectorOptions& options);

/// FrameDetections of given proposals, scoring boxes by score * IoU.
std::unique_ptr<const FrameDetections> DetectionsFromProposals(std::vector<Detection> proposals);

}  // namespace plumbline
