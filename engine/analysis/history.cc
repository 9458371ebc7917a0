// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/history.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "engine/analysis/reliability.h"
#include "engine/geometry/gravity.h"
#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

constexpr double kFarthestTruth_m = 1.0;
constexpr double kLeastLabel = 0.02;
constexpr int kThumbnailWidth = 96;

const ModelView* ModelByName(const SequenceView& view, const std::string& name) {
  for (const ModelView& model : view.models) {
    if (model.name == name) return &model;
  }
  return nullptr;
}

double AzimuthError(const ModelView& model, double azimuth_rad) {
  if (model.any_azimuth) return 0;
  const double period = 2 * std::numbers::pi / std::max(1, model.symmetry_order);
  return std::remainder(azimuth_rad, period);
}

/// Where the truth lies in the object's belief; the belief is about the centres of the models.
float LevelOf(const ObjectReport& object, const SequenceView& view,
              const SequenceView::Truth& truth, const ModelView& true_model, double turned) {
  const auto label = static_cast<std::size_t>(object.label.value);
  const Eigen::Vector3d center =
      label < view.models.size() ? view.models[label].center : true_model.center;
  Eigen::Vector4d offset;
  offset << truth.world_from_object * true_model.center - object.world_from_object * center,
      -turned;
  return static_cast<float>(CredibleLevel(offset, object.covariance, true_model.any_azimuth));
}

}  // namespace

std::optional<TruthError> ErrorOf(const ObjectReport& object, const SequenceView& view) {
  const UprightFrame upright(-view.up_in_world);
  std::optional<TruthError> nearest;
  double nearest_m = kFarthestTruth_m;
  for (const SequenceView::Truth& truth : view.truth) {
    const ModelView* model = ModelByName(view, truth.model);
    if (model == nullptr || model->category != object.category) continue;
    const double distance_m =
        (truth.world_from_object.translation() - object.world_from_object.translation()).norm();
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    const double turned = upright.Azimuth(object.world_from_object.linear()) -
                          upright.Azimuth(truth.world_from_object.linear());
    const auto label = static_cast<std::size_t>(object.label.value);
    const double azimuth = AzimuthError(*model, turned);
    nearest = TruthError{truth.id, label < view.models.size() && &view.models[label] == model,
                         static_cast<float>(distance_m), static_cast<float>(std::abs(azimuth)),
                         LevelOf(object, view, truth, *model, azimuth)};
  }
  return nearest;
}

FrameSample SampleOf(const FrameReport& report, const SequenceView& view) {
  FrameSample sample;
  sample.frame = report.frame;
  sample.skipped = !report.skipped.empty();
  sample.timings = report.timings;
  for (const ObjectReport& object : report.objects) {
    ObjectSample& kept = sample.objects.emplace_back();
    kept.id = object.id;
    kept.state = object.state;
    kept.updated = object.updated;
    kept.label = object.label;
    for (const LabelProbability& label : object.label_probability) {
      if (label.probability >= kLeastLabel) kept.label_probability.push_back(label);
    }
    kept.position_std_m =
        static_cast<float>(std::sqrt(object.covariance.topLeftCorner<3, 3>().trace()));
    kept.azimuth_std_rad = static_cast<float>(std::sqrt(std::max(0.0, object.covariance(3, 3))));
    kept.phi_cnn = object.phi_cnn;
    kept.phi_edge = object.phi_edge;
    kept.log_evidence = static_cast<float>(object.log_evidence);
    kept.effective_sample_size = static_cast<float>(object.effective_sample_size);
    kept.visible_fraction = static_cast<float>(object.visible_fraction);
    kept.error = ErrorOf(object, view);
  }
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
