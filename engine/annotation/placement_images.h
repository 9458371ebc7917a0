// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "engine/annotation/annotation_images.h"
#include "engine/annotation/check_frames.h"
#include "engine/annotation/outline_scene.h"
#include "engine/base/progress.h"
#include "engine/dataset/sequence.h"
#include "engine/registration/constrained_fit.h"

namespace plumbline {

/// A model that is to go somewhere, for asking the images where.
struct PlacementQuestion {
  std::shared_ptr<const Sequence> sequence;
  std::shared_ptr<OutlineScene> outlines;
  AnnotationDocument document;
  std::string model;
  std::string instance;  ///< The one that is placed again, which hides nothing; "": a new one.
  Eigen::Vector3d up_in_scan{0, 0, 1};
  FreeMotion motion = FreeMotion::kAzimuthAndTranslation;
  double scale = 1;      ///< Of the model.
  FrameSelection among;  ///< The frames that may be looked at.
  std::string edges;     ///< As of AnnotationImages::Load.
};

/// The same few key frames, in which all placements of a model are compared.
class PlacementImages {
 public:
  /// The frames that show the place best. Nothing where fewer than two show it, the model has no
  /// outline, or the work was stopped. Some seconds.
  static std::optional<PlacementImages> Choose(const PlacementQuestion& question,
                                               const Eigen::Isometry3d& start,
                                               const WorkContext& work);

  const std::shared_ptr<const OutlineModel>& model() const { return model_; }
  const std::shared_ptr<const AnnotationImages>& images() const { return images_; }
  int size() const { return static_cast<int>(images_->images().size()); }
  /// As of MeanAgreement.
  double Agreement(const Eigen::Isometry3d& scan_from_object) const;

  struct Found {
    Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
    double agreement = 0;
  };
  /// The best pose around the start by the images alone: all azimuths coarsely, then the most
  /// promising as RefineByImages does it. Nothing where none is better, or the work was stopped. 5
  /// to 13 s.
  std::optional<Found> Search(const Eigen::Isometry3d& start, const WorkContext& work) const;

 private:
  PlacementImages() = default;

  Eigen::Vector3d up_in_scan_{0, 0, 1};
  FreeMotion motion_ = FreeMotion::kAzimuthAndTranslation;
  std::shared_ptr<const OutlineModel> model_;
  Occluders occluders_;
  std::shared_ptr<const AnnotationImages> images_;
};

/// Whether any of several placements agrees with the images: by 0.3 (0.4 to 0.7 is usual for poses
/// that are right, 0.1 for those that are not). If none does, the scan does not show the object.
bool AnyAgrees(std::span<const double> agreements);
/// Which of several placements the images clearly prefer to the first; 0 where they do not.
std::size_t PreferredByImages(std::span<const double> agreements);
/// Whether what was found in the images alone convinces beside these. The scan knows nothing of it,
/// and a chair's slats lie on other edges easily: better by 0.2.
bool Convinces(double agreement, std::span<const double> agreements);

}  // namespace plumbline
