// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/report_message.h"

#include "engine/mapping/option_changes.h"
#include "engine/recording/frame_codec.h"
#include "engine/transport/wire_values.h"
#include "engine/vio/landmark_loops.h"

namespace plumbline {
namespace {

Error BadReport(int frame) {
  return {ErrorCode::kCorrupt, "the mapper's report of frame " + std::to_string(frame) +
                                   " cannot be read; is it of "
                                   "another version?"};
}

}  // namespace

wire::Report ReportToWire(const FrameReport& report, bool particles) {
  wire::Report message;
  message.set_frame(report.frame);
  message.set_stamp_ns(report.stamp_ns);
  message.set_skipped(report.skipped);
  message.set_frame_record(EncodeFrame(report));
  for (const ObjectReport& object : report.objects) {
    wire::ReportObject& row = *message.add_objects();
    row.set_id(object.id.value);
    row.set_state(static_cast<std::uint32_t>(object.state));
    row.set_category(object.category);
    row.set_label(object.label.value);
    if (object.confirmed_frame) row.set_confirmed_frame(*object.confirmed_frame);
    row.set_updated(object.updated);
    SetTransform(object.world_from_object, *row.mutable_world_from_object());
    if (!object.modes.empty()) row.set_position_std_m(object.modes.front().position_std_m);
    row.set_object_record(EncodeObject(object));
    if (particles && object.particles != nullptr)
      row.set_particles(EncodeParticles(*object.particles));
  }
  for (const LifeEvent& event : report.events) {
    wire::ReportEvent& row = *message.add_events();
    row.set_kind(static_cast<std::uint32_t>(event.kind));
    row.set_object(event.object.value);
    row.set_other(event.other.value);
    row.set_text(event.kind == EventKind::kOptionsChanged   ? event.option_changes
                 : event.kind == EventKind::kPosesCorrected ? event.landmarks
                                                            : event.text);
  }
  return message;
}

Result<FrameReport> ReportFromWire(const wire::Report& message, int num_models) {
  FrameReport report;
  report.frame = message.frame();
  report.stamp_ns = message.stamp_ns();
  report.skipped = message.skipped();
  if (!DecodeFrame(message.frame_record(), report).ok()) return BadReport(report.frame);
  for (const wire::ReportObject& row : message.objects()) {
    ObjectReport& object = report.objects.emplace_back();
    if (!IsState(row.state())) return BadReport(report.frame);
    object.id = {row.id()};
    object.state = static_cast<ObjectState>(row.state());
    object.category = row.category();
    object.label = {row.label()};
    if (row.has_confirmed_frame()) object.confirmed_frame = row.confirmed_frame();
    object.updated = row.updated();
    if (!DecodeObject(row.object_record(), object).ok() || !NamesModels(object, num_models))
      return BadReport(report.frame);
    if (row.particles().empty()) continue;
    Result<std::vector<Particle>> particles = DecodeParticles(row.particles());
    if (!particles.ok() || !NameModels(*particles, num_models)) return BadReport(report.frame);
    object.particles = std::make_shared<const std::vector<Particle>>(std::move(*particles));
  }
  for (const wire::ReportEvent& row : message.events()) {
    if (row.kind() > static_cast<std::uint32_t>(EventKind::kPosesCorrected))
      return BadReport(report.frame);
    LifeEvent event;
    event.kind = static_cast<EventKind>(row.kind());
    event.object = {row.object()};
    event.other = {row.other()};
    event.text = row.text();
    if (event.kind == EventKind::kOptionsChanged) {
      event.option_changes = row.text();
      event.text = DescribeOptionChanges(event.option_changes);
    }
    if (event.kind == EventKind::kPosesCorrected) {
      event.landmarks = row.text();
      const auto edges = LandmarkEdgesFromText(event.landmarks);
      if (!edges.ok()) return BadReport(report.frame);
      event.text = DescribeLandmarkEdges(*edges);
    }
    report.events.push_back(std::move(event));
  }
  return report;
}

}  // namespace plumbline
