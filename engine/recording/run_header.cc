// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_header.h"

#include <cstring>
#include <string_view>

#include "engine/base/files.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/sensor/camera.h"

namespace plumbline {
namespace {

template <typename T>
void AppendBytes(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

template <typename Vector>
nlohmann::json ToArray(const Vector& v) {
  return std::vector<double>(v.data(), v.data() + v.size());
}

template <typename Vector>
Vector FromArray(const nlohmann::json& json) {
  Vector v;
  if (json.size() != static_cast<std::size_t>(v.size()))
    throw std::runtime_error("a vector of the wrong length");
  for (int i = 0; i < v.size(); ++i) v[i] = json.at(i).get<double>();
  return v;
}

}  // namespace

RunHeader HeaderOf(const MappingPipeline& pipeline) {
  const PipelineChoice& choice = pipeline.choice();
  const Sequence& sequence = pipeline.sequence();
  const ModelDatabase& database = *pipeline.database();
  RunHeader header;
  header.options = OptionsToJson(choice.options);
  header.seed = choice.seed;
  header.sequence_path = std::filesystem::absolute(choice.sequence).string();
  header.sequence_hash = SequenceFingerprint(sequence);
  header.models_path = std::filesystem::absolute(database.folder()).string();
  header.models_hash = database.content_hash();
  header.detector = pipeline.detector_description();
  header.edges = pipeline.edges_description();
  header.poses = pipeline.poses_description();
  if (choice.poses != kDatasetPoses)
    header.poses_path = std::filesystem::absolute(choice.poses).string();
  for (const CadModel& model : database.models())
    header.models.push_back({model.name, model.category});
  header.gravity_in_world = *sequence.gravity_in_world();
  header.floor_in_world = sequence.floor_in_world();
  header.camera = sequence.camera();
  header.rate_hz = sequence.rate_hz();
  header.first_frame = choice.frames.begin;
  header.end_frame = pipeline.end_frame();
  header.frame_step = choice.frames.step;
  return header;
}

nlohmann::json HeaderToJson(const RunHeader& header) {
  nlohmann::json models = nlohmann::json::array();
  for (const RunModel& model : header.models) {
    models.push_back({{"name", model.name}, {"category", model.category}});
  }
  nlohmann::json camera = IntrinsicsToJson(header.camera);
  camera["rate_hz"] = header.rate_hz;
  nlohmann::json json = {
      {"options", header.options},
      {"seed", header.seed},
      {"program_version", header.program_version},
      {"sequence", {{"path", header.sequence_path}, {"hash", header.sequence_hash}}},
      {"database",
       {{"path", header.models_path}, {"hash", header.models_hash}, {"models", models}}},
      {"detector", header.detector},
      {"edges", header.edges},
      {"poses", header.poses},
      {"gravity", ToArray(header.gravity_in_world)},
      {"camera", camera},
      {"frames",
       {{"first", header.first_frame}, {"end", header.end_frame}, {"step", header.frame_step}}},
      {"started", header.started}};
  if (!header.poses_path.empty()) json["poses_path"] = header.poses_path;
  if (header.floor_in_world) json["floor"] = ToArray(*header.floor_in_world);
  if (header.forked_after) json["forked_after"] = *header.forked_after;
  return json;
}

Result<RunHeader> HeaderFromJson(const nlohmann::json& json) {
  RunHeader header;
  try {
    header.options = json.at("options");
    header.seed = json.at("seed").get<std::uint64_t>();
    header.program_version = json.at("program_version").get<std::string>();
    header.sequence_path = json.at("sequence").at("path").get<std::string>();
    header.sequence_hash = json.at("sequence").at("hash").get<std::string>();
    header.models_path = json.at("database").at("path").get<std::string>();
    header.models_hash = json.at("database").at("hash").get<std::string>();
    for (const nlohmann::json& model : json.at("database").at("models")) {
      header.models.push_back(
          {model.at("name").get<std::string>(), model.at("category").get<std::string>()});
    }
    header.detector = json.at("detector").get<std::string>();
    header.edges = json.at("edges").get<std::string>();
    header.poses = json.at("poses").get<std::string>();
    header.poses_path = json.value("poses_path", "");
    header.gravity_in_world = FromArray<Eigen::Vector3d>(json.at("gravity"));
    if (json.contains("floor"))
      header.floor_in_world = FromArray<Eigen::Vector4d>(json.at("floor"));
    const nlohmann::json& camera = json.at("camera");
    header.camera = {camera.at("width").get<int>(), camera.at("height").get<int>(),
                     camera.at("fx").get<double>(), camera.at("fy").get<double>(),
                     camera.at("cx").get<double>(), camera.at("cy").get<double>()};
    header.rate_hz = camera.at("rate_hz").get<double>();
    header.first_frame = json.at("frames").at("first").get<int>();
    header.end_frame = json.at("frames").at("end").get<int>();
    header.frame_step = json.at("frames").at("step").get<int>();
    header.started = json.at("started").get<std::string>();
    if (json.contains("forked_after")) header.forked_after = json.at("forked_after").get<int>();
  } catch (const std::exception& error) {
    return Error{ErrorCode::kCorrupt,
                 std::string("its header cannot be read (") + error.what() + ")"};
  }
  return header;
}

Status CheckContinues(const RunHeader& stored, const RunHeader& now) {
  const auto differs = [](std::string_view what, std::string_view before, std::string_view after) {
    return Error{ErrorCode::kInvalidInput, std::string(what) + " of the run to resume was " +
                                               std::string(before) + " and now is " +
                                               std::string(after) +
                                               "; resume with the same, or start a new run"};
  };
  for (const auto& [key, value] : stored.options.items()) {
    const auto found = now.options.find(key);
    const std::string after = found == now.options.end() ? "missing" : found->dump();
    if (after != value.dump()) return differs("option '" + key + "'", value.dump(), after);
  }
  for (const auto& [key, value] : now.options.items()) {
    if (!stored.options.contains(key))
      return differs("option '" + key + "'", "missing", value.dump());
  }
  if (stored.seed != now.seed) {
    return differs("the seed", std::to_string(stored.seed), std::to_string(now.seed));
  }
  const std::pair<std::string_view, std::string RunHeader::*> texts[] = {
      {"the program version", &RunHeader::program_version},
      {"the source of poses", &RunHeader::poses},  // before the sequence, whose hash covers them
      {"the sequence", &RunHeader::sequence_hash},
      {"the model database", &RunHeader::models_hash},
      {"the detector", &RunHeader::detector},
      {"the edge detector", &RunHeader::edges}};
  for (const auto& [what, member] : texts) {
    if (stored.*member != now.*member) return differs(what, stored.*member, now.*member);
  }
  if (stored.first_frame != now.first_frame || stored.frame_step != now.frame_step) {
    const auto range = [](const RunHeader& h) {
      return std::to_string(h.first_frame) + "::" + std::to_string(h.frame_step);
    };
    return differs("the frame range", range(stored), range(now));
  }
  return {};
}

std::string SequenceFingerprint(const Sequence& sequence) {
  std::string bytes;
  const PinholeCamera& camera = sequence.camera();
  AppendBytes(camera.width, bytes);
  AppendBytes(camera.height, bytes);
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy, sequence.rate_hz()}) {
    AppendBytes(value, bytes);
  }
  if (const auto gravity = sequence.gravity_in_world()) {
    for (int i = 0; i < 3; ++i) AppendBytes((*gravity)[i], bytes);
  }
  if (const auto floor = sequence.floor_in_world()) {
    for (int i = 0; i < 4; ++i) AppendBytes((*floor)[i], bytes);
  }
  for (int frame = 0; frame < sequence.num_frames(); ++frame) {
    AppendBytes(sequence.stamp_ns(frame), bytes);
    const auto pose = sequence.world_from_cam(frame);
    if (!pose) continue;
    for (int i = 0; i < 12; ++i) AppendBytes(pose->matrix()(i / 4, i % 4), bytes);
  }
  return HashHex(bytes);
}

}  // namespace plumbline
