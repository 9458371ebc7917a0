// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/map_object.h"

#include "engine/mapping/bytes.h"

namespace plumbline {

void MapObject::Summarize(const MapFrame& map) {
  modes = FindModes(particles, world_from_reference_cam, map);
  covariance = ModeCovariance(modes.front(), particles, world_from_reference_cam, map);
  label_probability = LabelPosterior(particles);
}

ObjectReport ToReport(const MapObject& object) {
  ObjectReport report;
  report.id = object.id;
  report.state = object.state;
  report.category = object.category;
  report.reference_frame = object.reference_frame;
  report.world_from_reference_cam = object.world_from_reference_cam;
  report.first_frame = object.first_frame;
  report.confirmed_frame = object.confirmed_frame;
  report.last_frame = object.last_frame;
  report.label = object.mean().label;
  report.label_probability = object.label_probability;
  report.world_from_object = object.mean().world_from_object;
  report.covariance = object.covariance;
  report.modes = object.modes;
  report.effective_sample_size = object.effective_sample_size;
  report.log_evidence = object.log_evidence;
  report.weighed = object.weighed;
  report.visible_fraction = object.visible_fraction;
  report.phi_cnn = object.phi_cnn;
  report.phi_edge = object.phi_edge;
  report.whole_box = object.whole_box;
  report.visible_box = object.visible_box;
  report.particles = std::make_shared<const std::vector<Particle>>(object.particles);
  ByteWriter out;
  out.Put(object.seen_s);
  out.Put(static_cast<std::int32_t>(object.last_move_frame));
  out.Put(object.last_proposal.has_value());
  if (object.last_proposal) {
    for (const float value :
         {object.last_proposal->box.x0, object.last_proposal->box.y0, object.last_proposal->box.x1,
          object.last_proposal->box.y1, object.last_proposal->score}) {
      out.Put(value);
    }
    out.Put(object.world_from_proposal_cam);
  }
  report.filter_state = out.Take();
  return report;
}

Result<MapObject> FromReport(const ObjectReport& report) {
  MapObject object;
  object.id = report.id;
  object.state = report.state;
  object.category = report.category;
  object.reference_frame = report.reference_frame;
  object.world_from_reference_cam = report.world_from_reference_cam;
  object.first_frame = report.first_frame;
  object.confirmed_frame = report.confirmed_frame;
  object.last_frame = report.last_frame;
  object.label_probability = report.label_probability;
  object.covariance = report.covariance;
  object.modes = report.modes;
  object.effective_sample_size = report.effective_sample_size;
  object.log_evidence = report.log_evidence;
  object.visible_fraction = report.visible_fraction;
  object.phi_cnn = report.phi_cnn;
  object.phi_edge = report.phi_edge;
  object.whole_box = report.whole_box;
  object.visible_box = report.visible_box;
  ByteReader in(report.filter_state);
  object.seen_s = in.Get<double>();
  object.last_move_frame = in.Get<std::int32_t>();
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
  if (!in.ok() || report.modes.empty() || report.particles == nullptr ||
      report.particles->empty()) {
    return Error{ErrorCode::kCorrupt,
                 "object " + std::to_string(report.id.value) +
                     " in the run file lacks what is needed to resume; start the run again"};
  }
  object.particles = *report.particles;
  return object;
}

}  // namespace plumbline
