// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/map_object.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/geometry/angles.h"
#include "engine/mapping/bytes.h"

namespace plumbline {

namespace {

/// Of each shape but the first of `in_place` the larger of both probabilities, of that one the
/// smaller; together 1, falling.
std::vector<LabelProbability> MoreDoubtful(std::vector<LabelProbability> posterior,
                                           const std::vector<LabelProbability>& in_place) {
  for (const LabelProbability& shape : in_place) {
    const auto found =
        std::find_if(posterior.begin(), posterior.end(),
                     [&](const LabelProbability& other) { return other.label == shape.label; });
    if (found == posterior.end())
      posterior.push_back(shape);
    else if (shape.label == in_place.front().label)
      found->probability = std::min(found->probability, shape.probability);
    else
      found->probability = std::max(found->probability, shape.probability);
  }
  double sum = 0;
  for (const LabelProbability& shape : posterior) sum += shape.probability;
  for (LabelProbability& shape : posterior) shape.probability /= sum;
  std::stable_sort(posterior.begin(), posterior.end(),
                   [](const LabelProbability& a, const LabelProbability& b) {
                     return a.probability > b.probability;
                   });
  return posterior;
}

}  // namespace

void MapObject::Summarize(const MapFrame& map) {
  modes = FindModes(particles, world_from_reference_cam, map);
  covariance = ModeCovariance(modes.front(), particles, world_from_reference_cam, map);
  covariance.topLeftCorner<3, 3>() += shared_error;
  covariance += outline_covariance;
  label_probability = LabelPosterior(particles);
  label = mean().label;
  if (!shapes_in_place.empty() && shapes_in_place.front().label == label)
    label_probability = MoreDoubtful(std::move(label_probability), shapes_in_place);
  world_from_object = mean().world_from_object;
  scale = mean().scale;
  scale_std = mean().scale_std;
}

void MapObject::MoveTo(const PoseEstimate& reference, const MapFrame& map) {
  const Eigen::Isometry3d move = reference.world_from_cam * world_from_reference_cam.inverse();
  // Particles are bearing and depth before the camera, which go along, and an azimuth in the world.
  const Eigen::Vector3d ahead = map.upright.upright_rotation().col(0);
  const Eigen::Vector3d turned =
      map.upright.upright_rotation().transpose() * (move.linear() * ahead);
  const double yaw = std::atan2(turned.y(), turned.x());
  for (Particle& particle : particles)
    particle.azimuth = static_cast<float>(WrapAngle(static_cast<double>(particle.azimuth) + yaw));
  for (PoseHypothesis& hypothesis : joined) {
    hypothesis.center_in_world = move * hypothesis.center_in_world;
    hypothesis.azimuth_rad = WrapAngle(hypothesis.azimuth_rad + yaw);
  }
  world_from_proposal_cam = move * world_from_proposal_cam;
  world_from_reference_cam = reference.world_from_cam;
  reference_uncertainty = reference.uncertainty;
  reference_epoch = reference.epoch;
  motion = {};  // its places were of the world as it was
  last_search_s = -std::numeric_limits<double>::infinity();
  Summarize(map);
}

double MapObject::remembered() const {
  double sum = 0;
  for (const ObjectView& view : views) sum += view.weight;
  return sum;
}

ObjectReport ToReport(const MapObject& object) {
  ObjectReport report;
  static_cast<ObjectBelief&>(report) = object;
  report.particles = std::make_shared<const std::vector<Particle>>(object.particles);
  ByteWriter out;
  out.Put(object.seen_s);
  for (const double value : object.reference_uncertainty.drift.reshaped()) out.Put(value);
  out.Put(object.reference_pose.value);
  out.Put(object.reference_epoch);
  out.Put(object.passing);
  out.Put(object.remembered_evidence);
  out.Put(object.hidden);
  out.Put(object.rival.value);
  out.Put(object.rivalry);
  out.Put(static_cast<std::uint32_t>(object.joined.size()));
  for (const PoseHypothesis& hypothesis : object.joined) {
    out.Put(hypothesis.label.value);
    out.Put(hypothesis.azimuth_rad);
    for (int k = 0; k < 3; ++k) out.Put(hypothesis.center_in_world[k]);
  }
  out.Put(object.shown);
  out.Put(object.last_search_s);
  out.Put(object.present_weight);
  object.slopes.Save(out);
  out.Put(object.sharpness);
  out.Put(static_cast<std::uint32_t>(object.views.size()));
  for (const ObjectView& view : object.views) {
    out.Put(static_cast<std::int32_t>(view.frame));
    out.Put(view.weight);
  }
  out.Put(static_cast<std::uint32_t>(object.memory.size()));
  for (const float sum : object.memory) out.Put(sum);
  out.Put(object.last_proposal.has_value());
  if (object.last_proposal) {
    for (const float value :
         {object.last_proposal->box.x0, object.last_proposal->box.y0, object.last_proposal->box.x1,
          object.last_proposal->box.y1, object.last_proposal->score}) {
      out.Put(value);
    }
    out.Put(object.world_from_proposal_cam);
  }
  object.paper.Save(out);
  // Scales, then crops, motion, boxes, shared errors, those of outlines and other shapes come last
  // and only where there are any: older files have none.
  const bool compared = !object.shapes_in_place.empty(),
             outlined = compared || !object.outline_covariance.isZero(0),
             shares = outlined || !object.shared_error.isZero(0),
             boxed = shares || object.remembered_boxes != 0,
             followed = boxed || object.motion.boxes() > 0,
             looked_at = followed || !object.crops.looked_from().empty();
  if (looked_at ||
      std::any_of(object.joined.begin(), object.joined.end(),
                  [](const PoseHypothesis& hypothesis) { return hypothesis.log_scale != 0; })) {
    for (const PoseHypothesis& hypothesis : object.joined) out.Put(hypothesis.log_scale);
  }
  if (looked_at) object.crops.Save(out);
  if (followed) object.motion.Save(out);
  if (boxed) out.Put(object.remembered_boxes);
  if (shares) {
    for (const double value : object.shared_error.reshaped()) out.Put(value);
  }
  if (outlined) {
    for (const double value : object.outline_covariance.reshaped()) out.Put(value);
  }
  if (compared) {
    out.Put(static_cast<std::uint32_t>(object.shapes_in_place.size()));
    for (const LabelProbability& shape : object.shapes_in_place) {
      out.Put(shape.label.value);
      out.Put(shape.probability);
    }
  }
  report.filter_state = out.Take();
  return report;
}

Result<MapObject> FromReport(const ObjectReport& report, const ModelDatabase& models) {
  MapObject object;
  static_cast<ObjectBelief&>(object) = report;
  object.updated = false;
  ByteReader in(report.filter_state);
  object.seen_s = in.Get<double>();
  for (double& value : object.reference_uncertainty.drift.reshaped()) value = in.Get<double>();
  object.reference_pose.value = in.Get<std::int32_t>();
  object.reference_epoch = in.Get<int>();
  object.passing = in.Get<double>();
  object.remembered_evidence = in.Get<double>();
  object.hidden = in.Get<double>();
  object.rival.value = in.Get<std::int32_t>();
  object.rivalry = in.Get<double>();
  const std::uint32_t joined = in.Get<std::uint32_t>();
  for (std::uint32_t i = 0; i < joined && in.ok(); ++i) {
    PoseHypothesis hypothesis;
    hypothesis.label.value = in.Get<std::int32_t>();
    hypothesis.azimuth_rad = in.Get<double>();
    for (int k = 0; k < 3; ++k) hypothesis.center_in_world[k] = in.Get<double>();
    object.joined.push_back(hypothesis);
  }
  object.shown = in.Get<double>();
  object.last_search_s = in.Get<double>();
  object.present_weight = in.Get<double>();
  object.slopes.Restore(in);
  object.sharpness = in.Get<double>();
  const std::uint32_t views = in.Get<std::uint32_t>();
  for (std::uint32_t i = 0; i < views && in.ok(); ++i) {
    ObjectView view;
    view.frame = in.Get<std::int32_t>();
    view.weight = in.Get<double>();
    object.views.push_back(view);
  }
  const std::uint32_t sums = in.Get<std::uint32_t>();
  for (std::uint32_t i = 0; i < sums && in.ok(); ++i) object.memory.push_back(in.Get<float>());
  if (in.Get<bool>()) {
    Detection detection;
    detection.category = report.category;
    for (float* value : {&detection.box.x0, &detection.box.y0, &detection.box.x1, &detection.box.y1,
                         &detection.score}) {
      *value = in.Get<float>();
    }
    object.last_proposal = detection;
    object.world_from_proposal_cam = in.GetPose();
  }
  object.paper.Restore(in);
  if (!in.rest().empty()) {
    for (PoseHypothesis& hypothesis : object.joined) hypothesis.log_scale = in.Get<double>();
  }
  if (!in.rest().empty()) object.crops.Restore(in);
  if (!in.rest().empty()) object.motion.Restore(in);
  if (!in.rest().empty()) object.remembered_boxes = in.Get<double>();
  if (!in.rest().empty()) {
    for (double& value : object.shared_error.reshaped()) value = in.Get<double>();
  }
  if (in.rest().size() == sizeof(double) * 4) {  // until 2026-11-28: one deviation, all around
    Eigen::Vector4d outline_error;
    for (double& value : outline_error) value = in.Get<double>();
    object.outline_covariance = outline_error * outline_error.transpose();
  } else if (!in.rest().empty()) {
    for (double& value : object.outline_covariance.reshaped()) value = in.Get<double>();
  }
  const std::uint32_t shapes = in.rest().empty() ? 0 : in.Get<std::uint32_t>();
  for (std::uint32_t i = 0; i < shapes && in.ok(); ++i) {
    LabelProbability shape;
    shape.label.value = in.Get<std::int32_t>();
    shape.probability = in.Get<double>();
    object.shapes_in_place.push_back(shape);
  }
  const auto known = [&models](int label) {
    return label >= 0 && label < static_cast<int>(models.models().size());
  };
  const bool labels_are_known =
      std::all_of(object.joined.begin(), object.joined.end(),
                  [&](const PoseHypothesis& other) { return known(other.label.value); }) &&
      std::all_of(object.shapes_in_place.begin(), object.shapes_in_place.end(),
                  [&](const LabelProbability& shape) {
                    return known(shape.label.value) && shape.probability > 0 &&
                           shape.probability <= 1;
                  }) &&
      std::all_of(object.paper.means.begin(), object.paper.means.end(),
                  [&](const Particle& mean) { return known(mean.label); });
  if (!in.ok() || !labels_are_known || report.modes.empty() || report.particles == nullptr ||
      report.particles->empty() || object.memory.size() != report.particles->size()) {
    return Error{ErrorCode::kCorrupt,
                 "object " + std::to_string(report.id.value) +
                     " in the run file is not as this version continues it: another version wrote "
                     "it, or it is damaged; start the run again"};
  }
  object.particles = *report.particles;
  return object;
}

}  // namespace plumbline
