// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/history.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "engine/analysis/object_spread.h"
#include "engine/analysis/true_instances.h"
#include "engine/evaluation/credible_region.h"
#include "engine/geometry/gravity.h"
#include "engine/mapping/map_report.h"
#include "engine/sensor/pose_estimate.h"
#include "engine/snapshot/belief_tails.h"

namespace plumbline {
namespace {

constexpr double kLeastLabel = 0.02;
constexpr int kThumbnailWidth = 96;

double AzimuthError(const ModelView& model, double azimuth_rad) {
  if (model.any_azimuth) return 0;
  const double period = 2 * std::numbers::pi / std::max(1, model.symmetry_order);
  return std::remainder(azimuth_rad, period);
}

/// What the belief does not know of: where the image is that it refers to. Of (centre, azimuth).
Eigen::Matrix4d ReferenceError(const ObjectReport& object, const Eigen::Vector3d& center_in_world,
                               const SequenceView& view) {
  const auto frame = static_cast<std::size_t>(object.reference_frame);
  if (frame >= view.aligned_pose_covariance.size()) return Eigen::Matrix4d::Zero();
  const PoseCovariance moved =
      MovedBy(center_in_world - object.world_from_reference_cam.translation(),
              view.aligned_pose_covariance[frame]);
  Eigen::Matrix<double, 4, 6> of_object = Eigen::Matrix<double, 4, 6>::Zero();
  of_object.topLeftCorner<3, 3>().setIdentity();
  of_object.block<1, 3>(3, 3) = view.up_in_world.transpose();
  return of_object * moved * of_object.transpose();
}

/// The object's belief, about the centres of the models; its heaviest mode, which is the mean that
/// it reports, comes first and has the full covariance.
std::vector<BeliefMode> ModesOf(const ObjectReport& object, const SequenceView& view,
                                const UprightFrame& upright) {
  const auto mode_of = [&](ModelId label, const Eigen::Isometry3d& world_from_object,
                           double scale) {
    BeliefMode mode;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    if (const auto index = static_cast<std::size_t>(label.value); index < view.models.size()) {
      const ModelView& model = view.models[index];
      center = model.center;
      mode.symmetry_order = model.any_azimuth ? 0 : std::max(1, model.symmetry_order);
    }
    mode.mean << world_from_object * (scale * center), upright.Azimuth(world_from_object.linear());
    return mode;
  };
  std::vector<BeliefMode> modes = {mode_of(object.label, object.world_from_object, object.scale)};
  modes.front().covariance = object.covariance;
  for (std::size_t i = 0; i < object.modes.size(); ++i) {
    const PoseMode& reported = object.modes[i];
    if (i > 0) {
      modes.push_back(mode_of(reported.label, reported.world_from_object, reported.scale));
      const double variance_m2 = reported.position_std_m * reported.position_std_m / 3;
      modes.back().covariance.diagonal() << variance_m2, variance_m2, variance_m2,
          reported.azimuth_std_rad * reported.azimuth_std_rad;
    }
    modes.back().weight = reported.weight;
  }
  if (!(modes.front().weight > 0)) {  // nothing but a mean
    modes.resize(1);
    modes.front().weight = 1;
  }
  const Eigen::Matrix4d reference = ReferenceError(object, modes.front().mean.head<3>(), view);
  for (BeliefMode& mode : modes) {
    mode.covariance += reference;
    mode.degrees_of_freedom = kBeliefDegreesOfFreedom;
  }
  return modes;
}

void JudgeBelief(const ObjectReport& object, const SequenceView& view,
                 const SequenceView::Truth& truth, const ModelView& true_model,
                 const UprightFrame& upright, TruthError& error) {
  TrueState state;
  state.state << truth.world_from_object * (truth.scale * true_model.center),
      upright.Azimuth(truth.world_from_object.linear());
  state.position_std_m = truth.position_std_m;
  state.azimuth_std_rad = truth.azimuth_std_rad;
  state.symmetry_order = true_model.any_azimuth ? 0 : std::max(1, true_model.symmetry_order);
  const std::vector<BeliefMode> modes = ModesOf(object, view, upright);
  error.credible_level = static_cast<float>(CredibleLevel(modes, state));
  const Nees nees = NeesOf(modes.front(), state);
  error.nees = static_cast<float>(nees.value);
  error.degrees_of_freedom = nees.degrees_of_freedom;
  error.several_models =
      std::count_if(view.models.begin(), view.models.end(), [&](const ModelView& model) {
        return model.category == true_model.category;
      }) > 1;
}

}  // namespace

std::vector<std::optional<TruthError>> ErrorsOf(const FrameReport& report,
                                                const SequenceView& view) {
  const UprightFrame upright(-view.up_in_world);
  const std::vector<std::optional<int>> pairs = TruthsOfObjects(report, view);
  std::vector<std::optional<TruthError>> errors(report.objects.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (!pairs[i]) continue;
    const ObjectReport& object = report.objects[i];
    const SequenceView::Truth& truth = view.truth[static_cast<std::size_t>(*pairs[i])];
    const ModelView* true_model = ModelByName(view, truth.model);
    const double turned = upright.Azimuth(object.world_from_object.linear()) -
                          upright.Azimuth(truth.world_from_object.linear());
    const auto label = static_cast<std::size_t>(object.label.value);
    TruthError& error = errors[i].emplace();
    error.truth = truth.id;
    error.model_correct = label < view.models.size() && &view.models[label] == true_model;
    error.translation_m = static_cast<float>(
        (truth.world_from_object.translation() - object.world_from_object.translation()).norm());
    error.azimuth_rad = static_cast<float>(std::abs(AzimuthError(*true_model, turned)));
    JudgeBelief(object, view, truth, *true_model, upright, error);
  }
  return errors;
}

FrameSample SampleOf(const FrameReport& report, const SequenceView& view,
                     const TruthVisibility* truths) {
  FrameSample sample;
  sample.frame = report.frame;
  sample.skipped = !report.skipped.empty();
  sample.timings = report.timings;
  const std::vector<std::optional<TruthError>> errors = ErrorsOf(report, view);
  for (std::size_t i = 0; i < report.objects.size(); ++i) {
    const ObjectReport& object = report.objects[i];
    ObjectSample& kept = sample.objects.emplace_back();
    kept.id = object.id;
    kept.state = object.state;
    kept.updated = object.updated;
    kept.label = object.label;
    for (const LabelProbability& label : object.label_probability) {
      if (label.probability >= kLeastLabel) kept.label_probability.push_back(label);
    }
    const ObjectSpread spread = SpreadOfModes(object, view);
    kept.position_std_m = static_cast<float>(spread.position_std_m);
    kept.azimuth_std_rad = static_cast<float>(spread.azimuth_std_rad.value_or(0));
    kept.round = !spread.azimuth_std_rad;
    kept.phi_cnn = object.phi_cnn;
    kept.phi_edge = object.phi_edge;
    kept.log_evidence = static_cast<float>(object.log_evidence);
    kept.effective_sample_size = static_cast<float>(object.effective_sample_size);
    kept.visible_fraction = static_cast<float>(object.visible_fraction);
    kept.error = errors[i];
  }
  if (truths != nullptr)
    sample.truths = TruthSamplesOf(report, view, TruthsOfObjects(report, view), *truths);
  return sample;
}

cv::Mat ThumbnailOf(const cv::Mat& image) {
  cv::Mat small;
  if (image.empty()) return small;
  const int height = std::max(1, image.rows * kThumbnailWidth / image.cols);
  cv::resize(image, small, {kThumbnailWidth, height}, 0, 0, cv::INTER_AREA);
  return small;
}

bool WantsThumbnail(int position, int size) {
  return position % ((size + kMaxThumbnails - 1) / kMaxThumbnails) == 0;
}

}  // namespace plumbline
