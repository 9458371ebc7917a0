// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_summary.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"
#include "engine/geometry/gravity.h"
#include "engine/mapping/map_report.h"
#include "engine/recording/object_mixture.h"
#include "engine/recording/smoothed_record.h"

namespace plumbline {
namespace {

double Degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

std::string ModelName(const RunHeader& header, ModelId label) {
  const auto index = static_cast<std::size_t>(label.value);
  return index < header.models.size() ? header.models[index].name : "";
}

/// Where it is not fixed at 1.
template <typename ModeOrObject>
void AddScale(const ModeOrObject& of, nlohmann::json& json) {
  if (of.scale == 1 && of.scale_std == 0) return;
  json["scale"] = of.scale;
  json["scale_std"] = of.scale_std;
}

nlohmann::json ModeToJson(const PoseMode& mode, const RunHeader& header,
                          const UprightFrame& upright) {
  nlohmann::json json = {{"model", ModelName(header, mode.label)},
                         {"weight", mode.weight},
                         {"world_from_object", IsometryToJson(mode.world_from_object)},
                         {"azimuth_deg", Degrees(upright.Azimuth(mode.world_from_object.linear()))},
                         {"position_std_m", mode.position_std_m},
                         {"azimuth_std_deg", Degrees(mode.azimuth_std_rad)}};
  AddScale(mode, json);
  return json;
}

double ProbabilityOf(const ObjectBelief& object) {
  return 1 / (1 + std::exp(-object.log_evidence));
}

nlohmann::json RowsToJson(const Eigen::Matrix4d& matrix) {
  nlohmann::json rows = nlohmann::json::array();
  for (int row = 0; row < 4; ++row)
    rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)});
  return rows;
}

nlohmann::json ObjectToJson(const ObjectReport& object, const RunHeader& header,
                            const UprightFrame& upright, const ModelDatabase* models) {
  nlohmann::json labels = nlohmann::json::object();
  for (const LabelProbability& entry : object.label_probability) {
    labels[ModelName(header, entry.label)] = entry.probability;
  }
  nlohmann::json modes = nlohmann::json::array();
  for (const PoseMode& mode : object.modes) modes.push_back(ModeToJson(mode, header, upright));
  const Eigen::Matrix4d covariance = MixtureCovariance(object, upright, models);
  nlohmann::json json = {
      {"id", object.id.value},
      {"model", ModelName(header, object.label)},
      {"category", object.category},
      {"confirmed", object.state == ObjectState::kConfirmed},
      {"probability", ProbabilityOf(object)},
      {"world_from_object", IsometryToJson(object.world_from_object)},
      {"azimuth_deg", Degrees(upright.Azimuth(object.world_from_object.linear()))},
      {"position_std_m", std::sqrt(covariance.topLeftCorner<3, 3>().trace())},
      {"azimuth_std_deg", Degrees(std::sqrt(covariance(3, 3)))},
      {"covariance", RowsToJson(covariance)},
      {"label_probability", std::move(labels)},
      {"modes", std::move(modes)},
      {"first_frame", object.first_frame},
      {"confirmed_frame",
       object.confirmed_frame ? nlohmann::json(*object.confirmed_frame) : nullptr},
      {"last_frame", object.last_frame}};
  AddScale(object, json);
  return json;
}

void AddEstimate(const ObjectReport& object, const RunHeader& header,
                 std::vector<EstimatedObject>& estimates) {
  if (object.state == ObjectState::kRetired) return;
  estimates.push_back({std::to_string(object.id.value), ModelName(header, object.label),
                       object.category, object.world_from_object, object.scale, std::nullopt,
                       ProbabilityOf(object), object.state == ObjectState::kConfirmed});
  if (object.scale_std > 0) estimates.back().scale_std = object.scale_std;
}

/// Mean, and the smallest value that 95 % do not exceed.
nlohmann::json StageToJson(std::vector<double> milliseconds) {
  double sum = 0;
  for (const double value : milliseconds) sum += value;
  const std::size_t count = milliseconds.size();
  const std::size_t rank = (count * 95 + 99) / 100 - 1;
  std::nth_element(milliseconds.begin(), milliseconds.begin() + static_cast<std::ptrdiff_t>(rank),
                   milliseconds.end());
  return {{"mean", sum / static_cast<double>(count)}, {"p95", milliseconds[rank]}};
}

Result<std::vector<EstimatedObject>> EstimatesFromJson(const nlohmann::json& json,
                                                       const std::string& file) {
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput,
                 file + " is not a result of 'plumbline run --json': " + what};
  };
  if (!json.is_object() || !json.contains("objects") || !json["objects"].is_array()) {
    return bad("it has no list 'objects'");
  }
  std::vector<EstimatedObject> estimates;
  for (const nlohmann::json& object : json["objects"]) {
    if (!object.is_object() || !object.contains("id")) return bad("an object has no 'id'");
    const std::string id =
        object["id"].is_string() ? object["id"].get<std::string>() : object["id"].dump();
    const std::optional<std::string> model = TextFromJson(object, "model");
    const std::optional<std::string> category = TextFromJson(object, "category");
    if (!model || !category) return bad("object " + id + " needs texts 'model' and 'category'");
    if (!object.contains("confirmed") || !object["confirmed"].is_boolean()) {
      return bad("object " + id + " needs 'confirmed', true or false");
    }
    const bool confirmed = object["confirmed"];
    const std::optional<Eigen::Isometry3d> pose =
        object.contains("world_from_object") ? IsometryFromJson(object["world_from_object"])
                                             : std::nullopt;
    if (!pose)
      return bad("object " + id +
                 " needs 'world_from_object', a 4x4 rigid transform within 1000 km");
    estimates.push_back(
        {id, *model, *category, *pose, 1, std::nullopt, confirmed ? 1.0 : 0.0, confirmed});
    for (const auto& [key, value] : object.items()) {
      if (key == "probability" && value.is_number()) estimates.back().probability = value;
      if (key != "scale" && key != "scale_std") continue;
      if (!value.is_number() || !(value > 0)) return bad("object " + id + " has a wrong " + key);
      if (key == "scale") estimates.back().scale = value;
      if (key == "scale_std") estimates.back().scale_std = value.get<double>();
    }
  }
  return estimates;
}

/// The newest frame that was not skipped; nothing where there is none.
Result<std::optional<FrameReport>> LastUsedFrame(RunReader& reader) {
  const Result<std::vector<RunFrame>> frames = reader.Frames();
  if (!frames) return frames.error();
  const auto last =
      std::find_if(frames->rbegin(), frames->rend(), [](const RunFrame& f) { return !f.skipped; });
  if (last == frames->rend()) return std::optional<FrameReport>();
  Result<FrameReport> report = reader.ReadFrame(last->position);
  if (!report) return report.error();
  return std::optional<FrameReport>(std::move(*report));
}

}  // namespace

std::vector<EstimatedObject> ConfirmedOf(std::vector<EstimatedObject> candidates) {
  std::erase_if(candidates, [](const EstimatedObject& object) { return !object.confirmed; });
  return candidates;
}

void RunSummary::AddTiming(bool skipped, const std::vector<StageTiming>& stages) {
  ++frames_;
  skipped_ += skipped;
  for (const StageTiming& timing : stages) {
    const auto found = std::find_if(stages_.begin(), stages_.end(),
                                    [&](const auto& stage) { return stage.first == timing.stage; });
    if (found != stages_.end()) {
      found->second.push_back(timing.milliseconds);
    } else {
      stages_.emplace_back(timing.stage, std::vector{timing.milliseconds});
    }
  }
}

Status RunSummary::CheckAnyFrameUsed(const std::string& sequence) const {
  if (skips_.empty() || skipped_ < frames_) return {};
  const auto commonest =
      std::max_element(skips_.begin(), skips_.end(),
                       [](const Skips& a, const Skips& b) { return a.count < b.count; });
  return Error{ErrorCode::kInvalidInput,
               "none of the " + std::to_string(frames_) + " frames of '" + sequence +
                   "' could be used, " + std::to_string(commonest->count) +
                   " of them because of this: " + commonest->first_text +
                   "; correct the sequence or choose other frames with --frames ('plumbline info' "
                   "says what the sequence holds)"};
}

void RunSummary::Add(const FrameReport& report) {
  AddTiming(!report.skipped.empty(), report.timings);
  if (!report.skipped.empty()) {
    auto same = std::find_if(skips_.begin(), skips_.end(),
                             [&](const Skips& skips) { return skips.cause == report.skip_cause; });
    if (same == skips_.end()) same = skips_.insert(same, {report.skip_cause, report.skipped});
    ++same->count;
    return;
  }
  objects_ = std::make_shared<const std::vector<ObjectReport>>(report.objects);
}

nlohmann::json RunSummary::ToJson(const RunHeader& header, double seconds,
                                  const ModelDatabase* models) const {
  const UprightFrame upright(header.gravity_in_world);
  nlohmann::json objects = nlohmann::json::array();
  if (objects_ != nullptr) {
    for (const ObjectReport& object : *objects_) {
      if (object.state != ObjectState::kRetired)
        objects.push_back(ObjectToJson(object, header, upright, models));
    }
  }
  nlohmann::json timings = nlohmann::json::object();
  for (const auto& [stage, milliseconds] : stages_) timings[stage] = StageToJson(milliseconds);
  nlohmann::json made_from = HeaderToJson(header);
  return {{"frames", frames_},
          {"skipped", skipped_},
          {"seconds", seconds},
          {"fps", seconds > 0 ? frames_ / seconds : 0.0},
          {"objects", std::move(objects)},
          {"timings_ms", std::move(timings)},
          {"run", std::move(made_from)}};
}

nlohmann::json SmoothedToJson(const SmoothedMap& map, const RunHeader& header,
                              const ModelDatabase* models) {
  const UprightFrame upright(header.gravity_in_world);
  nlohmann::json objects = nlohmann::json::array();
  for (const SmoothedObject& object : map.objects) {
    nlohmann::json json = ObjectToJson(object.belief, header, upright, models);
    json["spawned_frame"] = object.spawned_frame;
    json["looks"] = object.looks;
    json["looks_before_spawned"] = object.looks_before;
    json["views"] = object.views;
    json["refined_by_outline"] = object.refined;
    json["agreement"] = object.agreement;
    json["pushed_m"] = object.pushed_m;
    objects.push_back(std::move(json));
  }
  nlohmann::json floor = nullptr;
  if (map.floor_objects > 0) {
    floor = {{"objects", map.floor_objects},
             {"height_m", map.floor_height_m},
             {"std_m", map.floor_std_m}};
  }
  return {{"last_frame", map.last_frame},
          {"looks", map.looks},
          {"floor", std::move(floor)},
          {"objects", std::move(objects)}};
}

Result<std::vector<WithdrawnObject>> ReadWithdrawn(RunReader& reader) {
  const Result<std::vector<RunEvent>> events = reader.Events();
  if (!events) return events.error();
  const Result<std::vector<ObjectTrack>> tracks = reader.ObjectTracks();
  if (!tracks) return tracks.error();
  std::vector<WithdrawnObject> withdrawn;
  for (const RunEvent& event : *events) {
    const EventKind kind = event.event.kind;
    if (kind != EventKind::kRetired && kind != EventKind::kMerged) continue;
    const auto track = std::find_if(tracks->begin(), tracks->end(), [&](const ObjectTrack& of) {
      return of.id == event.event.object;
    });
    if (track == tracks->end() || !track->confirmed_frame) continue;
    WithdrawnObject& object = withdrawn.emplace_back();
    object.id = track->id;
    object.category = track->category;
    object.confirmed_frame = *track->confirmed_frame;
    object.withdrawn_frame = event.frame;
    if (kind == EventKind::kMerged) object.merged_into = event.event.other;
    object.why = event.event.text;
  }
  return withdrawn;
}

nlohmann::json WithdrawnToJson(const std::vector<WithdrawnObject>& objects) {
  nlohmann::json list = nlohmann::json::array();
  for (const WithdrawnObject& object : objects) {
    list.push_back({{"id", object.id.value},
                    {"category", object.category},
                    {"confirmed_frame", object.confirmed_frame},
                    {"withdrawn_frame", object.withdrawn_frame},
                    {"merged_into", object.merged_into ? nlohmann::json(object.merged_into->value)
                                                       : nlohmann::json(nullptr)},
                    {"why", object.why}});
  }
  return list;
}

Result<nlohmann::json> RunResultJson(RunReader& reader, const ModelDatabase* models) {
  const Result<std::vector<RunTiming>> timings = reader.Timings();
  if (!timings) return timings.error();
  RunSummary summary;
  for (const RunTiming& frame : *timings) summary.AddTiming(frame.skipped, frame.stages);
  Result<std::optional<FrameReport>> last = LastUsedFrame(reader);
  if (!last) return last.error();
  if (*last) {
    summary.objects_ =
        std::make_shared<const std::vector<ObjectReport>>(std::move((*last)->objects));
  }
  nlohmann::json json =
      summary.ToJson(reader.header(), timings->empty() ? 0.0 : timings->back().elapsed_s, models);
  const auto withdrawn = ReadWithdrawn(reader);
  if (!withdrawn) return withdrawn.error();
  json["withdrawn"] = WithdrawnToJson(*withdrawn);
  const auto smoothed = ReadSmoothed(reader.file());
  if (!smoothed) return smoothed.error();
  if (*smoothed) json["smoothed"] = SmoothedToJson(**smoothed, reader.header(), models);
  return json;
}

Result<std::vector<EstimatedObject>> ReadCandidates(const std::filesystem::path& run) {
  if (run.extension() == ".json") {
    const Result<nlohmann::json> json = ReadJson(run);
    if (!json) return json.error();
    return EstimatesFromJson(*json, run.string());
  }
  const Result<std::unique_ptr<RunReader>> reader = RunReader::Open(run);
  if (!reader) return reader.error();
  const Result<std::optional<FrameReport>> last = LastUsedFrame(**reader);
  if (!last) return last.error();
  std::vector<EstimatedObject> estimates;
  if (!*last) return estimates;
  for (const ObjectReport& object : (*last)->objects)
    AddEstimate(object, (*reader)->header(), estimates);
  return estimates;
}

Result<std::optional<std::vector<EstimatedObject>>> ReadSmoothedCandidates(
    const std::filesystem::path& run) {
  using Estimates = std::optional<std::vector<EstimatedObject>>;
  if (run.extension() == ".json") {
    const Result<nlohmann::json> json = ReadJson(run);
    if (!json) return json.error();
    if (!json->is_object() || !json->contains("smoothed")) return Estimates();
    Result<std::vector<EstimatedObject>> estimates =
        EstimatesFromJson((*json)["smoothed"], run.string());
    if (!estimates) return estimates.error();
    return Estimates(std::move(*estimates));
  }
  const auto smoothed = ReadSmoothed(run);
  if (!smoothed) return smoothed.error();
  if (!*smoothed) return Estimates();
  const Result<std::unique_ptr<RunReader>> reader = RunReader::Open(run);
  if (!reader) return reader.error();
  std::vector<EstimatedObject> estimates;
  for (const SmoothedObject& object : (*smoothed)->objects)
    AddEstimate(object.belief, (*reader)->header(), estimates);
  return Estimates(std::move(estimates));
}

Result<std::vector<EstimatedObject>> ReadEstimates(const std::filesystem::path& run) {
  Result<std::vector<EstimatedObject>> candidates = ReadCandidates(run);
  if (!candidates) return candidates.error();
  return ConfirmedOf(std::move(*candidates));
}

Result<std::optional<std::vector<EstimatedObject>>> ReadSmoothedEstimates(
    const std::filesystem::path& run) {
  auto candidates = ReadSmoothedCandidates(run);
  if (candidates && *candidates) **candidates = ConfirmedOf(std::move(**candidates));
  return candidates;
}

}  // namespace plumbline
