// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/annotation/annotation_document.h"
#include "engine/base/progress.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// One image with its edges. Immutable; copies share the pixels.
struct AnnotationImage {
  int frame = 0;
  cv::Mat image;  ///< CV_8UC3 BGR.
  EdgeMap edges;
  Eigen::Isometry3d scan_from_cam = Eigen::Isometry3d::Identity();
};

/// The images that objects are checked in, with edges found once. Immutable; share it.
class AnnotationImages {
 public:
  /// Frames that cannot be read are left out with a warning.
  /// @param edges  `gradient`, `dataset` or FILE.onnx, as of CreateEdgeDetector; "" is `dataset`
  ///               where there are any, else `gradient`.
  /// Errors: as of CreateEdgeDetector; kNotFound when no frame can be used; kCancelled.
  static Result<std::shared_ptr<const AnnotationImages>> Load(
      std::shared_ptr<const Sequence> sequence, const AnnotationDocument& document,
      const std::vector<int>& frames, const std::string& edges, const WorkContext& work = {});
  /// From what is there already.
  static std::shared_ptr<const AnnotationImages> FromImages(const PinholeCamera& camera,
                                                            std::vector<AnnotationImage> images);

  const PinholeCamera& camera() const { return camera_; }
  const std::vector<AnnotationImage>& images() const { return images_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  AnnotationImages() = default;
  PinholeCamera camera_;
  std::vector<AnnotationImage> images_;
  std::vector<std::string> warnings_;
};

/// Images to refine on, and others to judge by what was found.
struct HeldOutImages {
  std::shared_ptr<const AnnotationImages> used,
      held_out;  ///< `held_out` is null where there is none.
};
/// Every third of three images or more is held out.
HeldOutImages HoldOutEveryThird(const std::shared_ptr<const AnnotationImages>& images);

}  // namespace plumbline
