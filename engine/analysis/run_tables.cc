// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/run_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/analysis/object_spread.h"
#include "engine/base/files.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/gravity.h"
#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

std::string Quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string ModelName(const RunReview& review, ModelId label) {
  const auto index = static_cast<std::size_t>(label.value);
  return Quoted(index < review.header.models.size() ? review.header.models[index].name : "");
}

double LabelProbabilityOf(const std::vector<LabelProbability>& labels) {
  return labels.empty() ? 0 : labels.front().probability;
}

}  // namespace

std::string ObjectsCsv(const RunReview& review) {
  const UprightFrame upright(-review.view.up_in_world);
  std::string csv =
      "id,model,category,state,x_m,y_m,z_m,azimuth_deg,position_std_m,azimuth_std_deg,"
      "label_probability,log_evidence,first_frame,confirmed_frame,last_frame";
  const bool scaled = std::any_of(review.last->objects.begin(), review.last->objects.end(),
                                  [](const ObjectReport& object) { return object.scale_std > 0; });
  csv += scaled ? ",scale,scale_std\n" : "\n";
  for (const ObjectReport& o : review.last->objects) {
    const ObjectSpread spread = SpreadOf(o, review.view);
    const Eigen::Vector3d p = o.world_from_object.translation();
    csv += fmt::format(
        "{},{},{},{},{:.6f},{:.6f},{:.6f},{},{:.6f},{},{:.6f},{:.4f},{},{},{}", o.id.value,
        ModelName(review, o.label), Quoted(o.category), NameOf(o.state), p.x(), p.y(), p.z(),
        spread.azimuth_std_rad
            ? fmt::format("{:.4f}", kDegPerRad * upright.Azimuth(o.world_from_object.linear()))
            : "",
        spread.position_std_m,
        spread.azimuth_std_rad ? fmt::format("{:.4f}", kDegPerRad * *spread.azimuth_std_rad) : "",
        LabelProbabilityOf(o.label_probability), o.log_evidence, o.first_frame,
        o.confirmed_frame ? fmt::format("{}", *o.confirmed_frame) : "", o.last_frame);
    csv += scaled ? fmt::format(",{:.5f},{:.5f}\n", o.scale, o.scale_std) : "\n";
  }
  return csv;
}

std::string FramesCsv(const RunReview& review) {
  std::string csv =
      "frame,id,model,state,updated,position_std_m,azimuth_std_deg,phi_cnn,phi_edge,log_evidence,"
      "effective_sample_size,visible_fraction,label_probability,truth,translation_error_m,"
      "azimuth_error_deg,credible_level\n";
  for (const auto& frame : review.history.frames) {
    for (const ObjectSample& o : frame->objects) {
      csv += fmt::format("{},{},{},{},{},{:.6f},{},{:.5f},{:.5f},{:.4f},{:.1f},{:.4f},{:.6f}",
                         frame->frame, o.id.value, ModelName(review, o.label), NameOf(o.state),
                         o.updated ? 1 : 0, o.position_std_m,
                         o.round ? "" : fmt::format("{:.4f}", kDegPerRad * o.azimuth_std_rad),
                         o.phi_cnn, o.phi_edge, o.log_evidence, o.effective_sample_size,
                         o.visible_fraction, LabelProbabilityOf(o.label_probability));
      csv += o.error ? fmt::format(
                           ",{},{:.6f},{},{:.5f}\n", Quoted(o.error->truth), o.error->translation_m,
                           o.round ? "" : fmt::format("{:.4f}", kDegPerRad * o.error->azimuth_rad),
                           o.error->credible_level)
                     : ",,,,\n";
    }
  }
  return csv;
}

std::string EventsCsv(const RunReview& review) {
  std::string csv = "frame,event,id,other_id,text\n";
  for (const RunEvent& event : review.events) {
    const auto id = [](ObjectId object) {
      return object.value > 0 ? fmt::format("{}", object.value) : std::string();
    };
    csv += fmt::format("{},{},{},{},{}\n", event.frame, NameOf(event.event.kind),
                       id(event.event.object), id(event.event.other), Quoted(event.event.text));
  }
  return csv;
}

std::string TimingsCsv(const RunReview& review) {
  std::vector<std::string> stages;
  for (const RunTiming& frame : review.timings) {
    for (const StageTiming& stage : frame.stages) {
      if (std::find(stages.begin(), stages.end(), stage.stage) == stages.end())
        stages.push_back(stage.stage);
    }
  }
  std::string csv = "frame,skipped,elapsed_s";
  for (std::string stage : stages) {
    std::replace(stage.begin(), stage.end(), ' ', '_');
    csv += "," + Quoted(stage + "_ms");
  }
  csv += "\n";
  for (const RunTiming& frame : review.timings) {
    csv += fmt::format("{},{},{:.4f}", frame.frame, frame.skipped ? 1 : 0, frame.elapsed_s);
    for (const std::string& stage : stages) {
      const auto found = std::find_if(frame.stages.begin(), frame.stages.end(),
                                      [&](const StageTiming& t) { return t.stage == stage; });
      csv += found == frame.stages.end() ? "," : fmt::format(",{:.4f}", found->milliseconds);
    }
    csv += "\n";
  }
  return csv;
}

Status WriteRunTables(const std::filesystem::path& folder, const RunReview& review) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return Error{ErrorCode::kIo, "cannot make the folder '" + folder.string() +
                                     "' for the tables: " + error.message()};
  for (const auto& [name, csv] : {std::pair("objects.csv", ObjectsCsv(review)),
                                  {"frames.csv", FramesCsv(review)},
                                  {"events.csv", EventsCsv(review)},
                                  {"timings.csv", TimingsCsv(review)}}) {
    if (Status status = WriteFileAtomically(folder / name, csv); !status.ok()) return status;
  }
  return {};
}

}  // namespace plumbline
