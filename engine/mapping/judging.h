// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/mapping/crop_belief.h"
#include "engine/mapping/cross_sections.h"
#include "engine/mapping/likelihood.h"
#include "engine/mapping/pose_sampler.h"

namespace plumbline {

/// An image to judge hypotheses of one object by.
struct JudgingView {
  ScoringView view;
  const FrameDetections* detections = nullptr;
  /// EdgeNormalizer, fixed so that log-likelihoods of different calls compare.
  float normalizer = 0;
  double weight = 1;  ///< How much of an independent view it is.
  /// Of Phi_cnn; nothing: as the shape has it (DetectorWeight).
  std::optional<double> detector_weight = {};
};

/// How many independent views `weight` views amount to, if errors of any two of them correlate by
/// `correlation`: their information does not grow beyond 1 / correlation.
double IndependentViews(double weight, double correlation);

/// What a sum over views of all together `weight` is multiplied by in a posterior: each counts as
/// `sharpness` views (likelihood_sharpness.h), and all as many as are independent.
double ViewScale(double weight, double sharpness, const MapperOptions& options);

/// Sum over views of weight * (alpha * Phi_cnn + beta * Phi_edge), for each hypothesis.
std::vector<double> SumOverViews(const HypothesisScorer& scorer, const MapFrame& map,
                                 std::span<const JudgingView> views,
                                 std::span<const PoseHypothesis> hypotheses,
                                 const MapperOptions& options);
/// Log density, unnormalised, of the height above the floor or a level (of a place all are as
/// likely), for shapes that stand there; of others, of the height above what is mapped below them.
/// 0 without a floor and without anything below.
double LogHeightPrior(const MapFrame& map, const PoseHypothesis& hypothesis,
                      const MapperOptions& options);

/// Log density of the scale, unnormalised: normal in its logarithm; 0 where it is fixed.
double LogScalePrior(const PoseHypothesis& hypothesis, const MapperOptions& options);

/// Log of the chance that cameras stand where the views do, if the model has a back (CadModel): no
/// camera looks through the wall that the back is put against, so one behind the plane of the back
/// takes log(seen_from_behind), one in front of it nothing. 0 for models without a back.
double LogBackPrior(const MapFrame& map, std::span<const Eigen::Vector3d> cameras_in_world,
                    const PoseHypothesis& hypothesis, const MapperOptions& options);

/// What an object that is settled fills, an upright elliptic cylinder: no other of its category can
/// have its centre there.
struct TakenPlace {
  Eigen::Isometry3d center_from_world = Eigen::Isometry3d::Identity();  ///< Axes of the object.
  Eigen::Vector3d half_sizes_m{0, 0, 0};

  bool Holds(const Eigen::Vector3d& center_in_world) const;
};
/// The place of a model: half of its bounds to each side, of a thin side more.
TakenPlace PlaceOf(const CadModel& model, const Eigen::Isometry3d& world_from_object, double scale);
/// The target, with hypotheses in places that are taken made as good as impossible.
Target Outside(std::vector<TakenPlace> taken, Target target);

/// How far what stands on the floor reaches into a top of something else [m]: the mean, over points
/// of its surface 3 cm above the top, of how deep they are inside the ellipse in the top's
/// rectangle (tops may be round). 0 for what ends below that, for shapes that need not stand on the
/// floor (LogSupportPrior), and for what is larger than the top: of the two the smaller gives way.
/// `sections` are those of each model of the map's database.
double DepthInTop(const SupportSurface& top, const std::vector<CrossSections>& sections,
                  const MapFrame& map, const PoseHypothesis& hypothesis);
/// The target, with hypotheses that reach into a top as good as impossible, unless the top is not
/// where it is mapped. References must outlive it.
Target ClearOf(std::vector<SupportSurface> tops, const std::vector<CrossSections>& sections,
               const MapFrame& map, Target target);

/// What crops say of a shape at an azimuth, in the log of a posterior.
double LogCrops(const CropBelief& crops, ModelId label, double azimuth_rad,
                const MapperOptions& options);
/// The target, with what crops say. `options` must outlive it.
Target WithCrops(CropBelief crops, const MapperOptions& options, Target target);

/// The posterior of one object: what its remembered views and the present one say, scaled to as
/// many independent views as they amount to (ViewScale), and the priors of height, scale and back.
/// References must outlive it.
Target Posterior(const HypothesisScorer& scorer, const MapFrame& map,
                 std::vector<JudgingView> remembered, const JudgingView& present,
                 const MapperOptions& options, double sharpness = 1);

}  // namespace plumbline
