// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "engine/annotation/annotation_document.h"
#include "engine/annotation/annotation_images.h"
#include "engine/annotation/occluders.h"
#include "engine/base/progress.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// Frames of a sequence: every `step`-th from `first` on, before `end`.
struct FrameSelection {
  int first = 0;           ///< >= 0
  std::optional<int> end;  ///< Nothing: to the last one.
  int step = 1;            ///< > 0

  bool Has(int frame) const {
    return frame >= first && (!end || frame < *end) && (frame - first) % step == 0;
  }
};

struct CheckFrameOptions {
  int frames = 8;             ///< At most so many, > 0.
  int max_candidates = 300;   ///< Frames looked at, evenly spread over the sequence, > 0.
  double min_inside = 0.1;    ///< Share of the model inside the image ...
  double min_visible = 0.05;  ///< ... and not hidden by the scan or other objects ...
  double min_of_best = 0.4;   ///< ... and, of the share in the frame that shows most, so much.
  double min_size_px = 24;    ///< Projected diameter.
  int sharpness_window = 2;   ///< Frames to either side among which the sharpest is taken, >= 0.
  FrameSelection among;       ///< No others are looked at.
};

/// A frame in which an object can be checked.
struct CheckFrame {
  int frame = 0;           ///< Index in the sequence.
  double visible = 0;      ///< Share of the model inside the image and not hidden by others.
  double distance_m = 0;   ///< Camera to the model's middle.
  double bearing_rad = 0;  ///< Of the camera as seen from the model, in the plane across gravity.
};

/// Frames that see the posed model well and from as different sides and distances as there are,
/// best first; the sharpest of neighbouring images. The same for the same input. Empty if no frame
/// sees it. Reads a few images for each frame chosen. Errors: kCancelled.
Result<std::vector<CheckFrame>> ChooseCheckFrames(
    const Sequence& sequence, const AnnotationDocument& document, const OutlineModel& model,
    const Eigen::Isometry3d& scan_from_object, const Occluders& occluders,
    const CheckFrameOptions& options = {}, const WorkContext& work = {});

/// The images of the frames that ChooseCheckFrames chooses; null if no frame sees the model.
/// Errors: of AnnotationImages::Load, kCancelled.
Result<std::shared_ptr<const AnnotationImages>> LoadCheckImages(
    const std::shared_ptr<const Sequence>& sequence, const AnnotationDocument& document,
    const OutlineModel& model, const Eigen::Isometry3d& scan_from_object,
    const Occluders& occluders, const CheckFrameOptions& options = {},
    const std::string& edges = "", const WorkContext& work = {});

}  // namespace plumbline
