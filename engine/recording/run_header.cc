// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_header.h"

#include <chrono>
#include <cstring>
#include <ctime>
#include <iterator>
#include <string_view>

#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/models/model_database.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/pipeline/own_pose_sequence.h"
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

std::string CurrentTime() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&now));
  return text;
}

/// Format 1 kept what the detectors said of themselves: "KIND FILE.onnx HASH" of a network, where
/// KIND is `network`. Its hash was made differently and says nothing here.
template <typename Source>
InputChoice<Source> ChoiceOfFormat1(const std::string& description, std::string_view network) {
  const auto& names = EnumNames<Source>::names;
  const std::size_t end = description.find(".onnx");
  if (description.starts_with(network) && end != std::string::npos) {
    return {static_cast<Source>(std::size(names) - 1),
            description.substr(network.size(), end + 5 - network.size()),
            {}};
  }
  for (std::size_t i = 0; i + 1 < std::size(names); ++i) {
    if (description.starts_with(names[i])) return {static_cast<Source>(i), {}, {}};
  }
  throw std::runtime_error("it was made with '" + description + "', which is not known");
}

/// The recipe of a run of format 1, whose header had no recipe.
RunRecipe RecipeOfFormat1(const nlohmann::json& json) {
  RunRecipe recipe;
  recipe.sequence = json.at("sequence").at("path").get<std::string>();
  recipe.models = json.at("database").at("path").get<std::string>();
  recipe.detector =
      ChoiceOfFormat1<DetectorSource>(json.at("detector").get<std::string>(), "fastestdet ");
  recipe.edges = ChoiceOfFormat1<EdgeSource>(json.at("edges").get<std::string>(), "edge network ");
  recipe.options = KnownOptions(json.at("options"));
  recipe.seed = UnsignedFromJson(json.at("seed"));
  const nlohmann::json& frames = json.at("frames");
  recipe.frames = {IntFromJson(frames.at("first")), IntFromJson(frames.at("end")),
                   IntFromJson(frames.at("step"))};
  return recipe;
}

}  // namespace

RunHeader HeaderOf(const MappingPipeline& pipeline, const std::string& program_version) {
  const Sequence& sequence = pipeline.sequence();
  const ModelDatabase& database = *pipeline.database();
  RunHeader header;
  header.recipe = pipeline.recipe();
  header.program_version = program_version;
  header.sequence_hash = SequenceFingerprint(sequence);
  header.models_hash = database.content_hash();
  for (const CadModel& model : database.models())
    header.models.push_back({model.name, model.category});
  header.gravity_in_world = *sequence.gravity_in_world();
  header.floor_in_world = sequence.floor_in_world();
  header.camera = sequence.camera();
  header.rate_hz = sequence.rate_hz();
  header.end_frame = pipeline.end_frame();
  header.started = CurrentTime();
  return header;
}

nlohmann::json HeaderToJson(const RunHeader& header) {
  nlohmann::json models = nlohmann::json::array();
  for (const RunModel& model : header.models) {
    models.push_back({{"name", model.name}, {"category", model.category}});
  }
  nlohmann::json camera = IntrinsicsToJson(header.camera);
  camera["rate_hz"] = header.rate_hz;
  nlohmann::json json = {{"recipe", RecipeToJson(header.recipe)},
                         {"program_version", header.program_version},
                         {"sequence_hash", header.sequence_hash},
                         {"models_hash", header.models_hash},
                         {"models", models},
                         {"gravity", ToArray(header.gravity_in_world)},
                         {"camera", camera},
                         {"end_frame", header.end_frame},
                         {"started", header.started}};
  if (header.floor_in_world) json["floor"] = ToArray(*header.floor_in_world);
  if (header.forked_after) json["forked_after"] = *header.forked_after;
  return json;
}

Result<RunHeader> HeaderFromJson(const nlohmann::json& json) {
  RunHeader header;
  try {
    const bool format1 = !json.contains("recipe");
    if (format1) {
      header.recipe = RecipeOfFormat1(json);
    } else {
      Result<RunRecipe> recipe = RecipeFromJson(json.at("recipe"));
      if (!recipe.ok()) return recipe.error();
      header.recipe = std::move(recipe).value();
    }
    header.program_version = json.at("program_version").get<std::string>();
    const nlohmann::json& database = format1 ? json.at("database") : json;
    header.sequence_hash =
        (format1 ? json.at("sequence").at("hash") : json.at("sequence_hash")).get<std::string>();
    header.models_hash = database.at(format1 ? "hash" : "models_hash").get<std::string>();
    for (const nlohmann::json& model : database.at("models")) {
      header.models.push_back(
          {model.at("name").get<std::string>(), model.at("category").get<std::string>()});
    }
    header.gravity_in_world = FromArray<Eigen::Vector3d>(json.at("gravity"));
    if (json.contains("floor"))
      header.floor_in_world = FromArray<Eigen::Vector4d>(json.at("floor"));
    const nlohmann::json& camera = json.at("camera");
    header.camera = {IntFromJson(camera.at("width")), IntFromJson(camera.at("height")),
                     camera.at("fx").get<double>(),   camera.at("fy").get<double>(),
                     camera.at("cx").get<double>(),   camera.at("cy").get<double>()};
    header.rate_hz = camera.at("rate_hz").get<double>();
    header.end_frame = IntFromJson(format1 ? json.at("frames").at("end") : json.at("end_frame"));
    header.started = json.at("started").get<std::string>();
    if (json.contains("forked_after")) header.forked_after = IntFromJson(json.at("forked_after"));
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
  const RunRecipe &was = stored.recipe, &is = now.recipe;
  if (was.live_speed || is.live_speed) {
    return Error{ErrorCode::kInvalidInput,
                 "a live run cannot be resumed: it cannot be repeated, either; start a new run, or "
                 "go on from it with --fork"};
  }
  const EdgeChoice was_edges = was.edges.value_or(EdgeChoice()),
                   is_edges = is.edges.value_or(EdgeChoice());
  const nlohmann::json options_were = OptionsToJson(was.options),
                       options_are = OptionsToJson(is.options);
  for (const auto& [key, value] : options_were.items()) {
    if (value != options_are.at(key))
      return differs("option '" + key + "'", value.dump(), options_are.at(key).dump());
  }
  if (was.seed != is.seed)
    return differs("the seed", std::to_string(was.seed), std::to_string(is.seed));
  if (stored.program_version != now.program_version)
    return differs("the program version", stored.program_version, now.program_version);
  const auto described = [](const auto& choice) { return ToText(choice) + " " + choice.hash; };
  // Poses before the sequence, whose hash covers them.
  if (!was.poses.SameContent(is.poses))
    return differs("the source of poses", described(was.poses), described(is.poses));
  if (stored.sequence_hash != now.sequence_hash)
    return differs("the sequence", stored.sequence_hash, now.sequence_hash);
  if (stored.models_hash != now.models_hash)
    return differs("the model database", stored.models_hash, now.models_hash);
  if (!was.detector.value_or(DetectorChoice()).SameContent(is.detector.value_or(DetectorChoice())))
    return differs("the detector", described(was.detector.value_or(DetectorChoice())),
                   described(is.detector.value_or(DetectorChoice())));
  if (!was_edges.SameContent(is_edges))
    return differs("the edge detector", described(was_edges), described(is_edges));
  if (was.scorer != is.scorer) return differs("the scorer", NameOf(was.scorer), NameOf(is.scorer));
  if (was.frames.begin != is.frames.begin || was.frames.step != is.frames.step) {
    const auto range = [](const FrameRange& frames) {
      return std::to_string(frames.begin) + "::" + std::to_string(frames.step);
    };
    return differs("the frame range", range(was.frames), range(is.frames));
  }
  return {};
}

std::string SequenceFingerprint(const Sequence& mapped) {
  const Sequence& sequence = GivenSequence(mapped);  // own poses follow from it and the recipe
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
  for (const FloorLevel& level : sequence.floor_levels()) {
    AppendBytes(level.height_m, bytes);
    AppendBytes(level.std_m, bytes);
    for (const Eigen::Vector3d& corner : level.outline_in_world) {
      for (int i = 0; i < 3; ++i) AppendBytes(corner[i], bytes);
    }
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
