// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/run_recipe.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/base/log.h"
#include "engine/vision/fetched_networks.h"

namespace plumbline {
namespace {

constexpr int kRecipeVersion = 2;

Result<int> ParseFrameNumber(std::string_view text, std::string_view whole) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + std::string(whole) +
                     "' is not a range of frames; write A:B or A:B:S, for instance 0:300:2"};
  }
  return value;
}

template <typename Source>
std::string_view SourceName(Source source) {
  return EnumNames<Source>::names[static_cast<std::size_t>(source)];
}

/// Throws std::runtime_error on a name that is not known.
template <typename Enum>
Enum EnumFromName(const std::string& name) {
  const auto& names = EnumNames<Enum>::names;
  const auto found = std::find(std::begin(names), std::end(names), name);
  if (found == std::end(names)) throw std::runtime_error("'" + name + "' is not known");
  return static_cast<Enum>(found - std::begin(names));
}

/// The last source is the one with a file.
template <typename Source>
InputChoice<Source> ParseChoice(const std::string& text) {
  const auto& names = EnumNames<Source>::names;
  const auto last = std::end(names) - 1;
  const auto found = std::find(std::begin(names), last, text);
  InputChoice<Source> choice;
  choice.source = static_cast<Source>(found - std::begin(names));
  if (found == last) choice.file = text;
  return choice;
}

template <typename Source>
std::string TextOf(const InputChoice<Source>& choice) {
  return choice.file.empty() ? std::string(SourceName(choice.source)) : choice.file.string();
}

/// "" stays "", and so does what is no file but another process (docs/processes.md).
std::string Absolute(const std::filesystem::path& path) {
  if (path.string().starts_with("process:")) return path.string();
  return path.empty() ? std::string() : std::filesystem::absolute(path).string();
}

template <typename Source>
nlohmann::json ChoiceToJson(const InputChoice<Source>& choice) {
  nlohmann::json json = {{"source", SourceName(choice.source)}};
  if (!choice.file.empty()) json["file"] = Absolute(choice.file);
  if (!choice.hash.empty()) json["hash"] = choice.hash;
  return json;
}

template <typename Source>
InputChoice<Source> ChoiceFromJson(const nlohmann::json& json) {
  return {EnumFromName<Source>(json.at("source").get<std::string>()), json.value("file", ""),
          json.value("hash", "")};
}

}  // namespace

Result<FrameRange> ParseFrameRange(std::string_view text) {
  FrameRange range;
  std::vector<std::string_view> parts;
  std::size_t from = 0;
  while (true) {
    const std::size_t colon = text.find(':', from);
    parts.push_back(text.substr(from, colon == std::string_view::npos ? colon : colon - from));
    if (colon == std::string_view::npos) break;
    from = colon + 1;
  }
  int numbers[3] = {0, 0, 1};
  for (std::size_t i = 0; i < parts.size() && i < 3; ++i) {
    if (parts[i].empty()) continue;
    Result<int> number = ParseFrameNumber(parts[i], text);
    if (!number.ok()) return number.error();
    numbers[i] = *number;
    if (i == 1) range.end = numbers[i];
  }
  if (parts.size() < 2 || parts.size() > 3 || numbers[2] < 1 ||
      (range.end && *range.end <= numbers[0])) {
    return Error{
        ErrorCode::kInvalidInput,
        "'" + std::string(text) + "' selects no frames; write A:B or A:B:S with A < B, S > 0"};
  }
  range.begin = numbers[0];
  range.step = numbers[2];
  return range;
}

PoseChoice ParsePoses(const std::string& text) { return ParseChoice<PoseSource>(text); }
EdgeChoice ParseEdges(const std::string& text) { return ParseChoice<EdgeSource>(text); }
DetectorChoice ParseDetector(const std::string& text) { return ParseChoice<DetectorSource>(text); }
std::string ToText(const PoseChoice& choice) { return TextOf(choice); }
std::string ToText(const EdgeChoice& choice) { return TextOf(choice); }
std::string ToText(const DetectorChoice& choice) { return TextOf(choice); }

EdgeChoice DefaultEdges(const Sequence& sequence) {
  return {sequence.has_edges() ? EdgeSource::kDataset : EdgeSource::kBuiltin, {}, {}};
}

DetectorChoice DefaultDetector(const Sequence& sequence) {
  if (sequence.has_proposals()) return DetectorChoice{DetectorSource::kDataset, {}, {}};
  if (const auto file = BestFetchedDetector())
    return DetectorChoice{DetectorSource::kNetwork, *file, {}};
  return DetectorChoice{DetectorSource::kBuiltin, {}, {}};
}

namespace {

template <typename Options>
Options KnownOptionsOf(const nlohmann::json& stored) {
  Options options;
  if (OptionsFromJson(stored, options).ok()) return options;
  for (const auto& [name, value] : stored.items()) {
    if (const Status status = OptionsFromJson({{name, value}}, options); !status.ok())
      log::warn("an option of the run is not known here: {}", status.error().message);
  }
  return options;
}

}  // namespace

MapperOptions KnownOptions(const nlohmann::json& stored) {
  return KnownOptionsOf<MapperOptions>(stored);
}

std::string HashOf(const OwnPoseOptions& options) { return HashHex(OptionsToJson(options).dump()); }

std::string_view NameOf(ScorerKind kind) { return SourceName(kind); }

nlohmann::json RecipeToJson(const RunRecipe& recipe) {
  nlohmann::json frames = {{"begin", recipe.frames.begin}, {"step", recipe.frames.step}};
  if (recipe.frames.end) frames["end"] = *recipe.frames.end;
  nlohmann::json json = {{"version", kRecipeVersion},
                         {"sequence", Absolute(recipe.sequence)},
                         {"poses", ChoiceToJson(recipe.poses)},
                         {"scorer", SourceName(recipe.scorer)},
                         {"options", OptionsToJson(recipe.options)},
                         {"seed", recipe.seed},
                         {"frames", frames}};
  if (!recipe.models.empty()) json["models"] = Absolute(recipe.models);
  if (recipe.live_speed) json["live_speed"] = *recipe.live_speed;
  if (recipe.detector) json["detector"] = ChoiceToJson(*recipe.detector);
  if (recipe.edges) json["edges"] = ChoiceToJson(*recipe.edges);
  if (recipe.poses.source == PoseSource::kVio) json["own_poses"] = OptionsToJson(recipe.own_poses);
  return json;
}

Result<RunRecipe> RecipeFromJson(const nlohmann::json& json) {
  RunRecipe recipe;
  try {
    if (IntFromJson(json.at("version")) > kRecipeVersion) {
      return Error{ErrorCode::kUnsupported,
                   "its recipe is of version " + json.at("version").dump() +
                       ", and this program reads up to " + std::to_string(kRecipeVersion) +
                       "; update this program"};
    }
    recipe.sequence = json.at("sequence").get<std::string>();
    recipe.models = json.value("models", "");
    recipe.poses = ChoiceFromJson<PoseSource>(json.at("poses"));
    if (json.contains("own_poses"))
      recipe.own_poses = KnownOptionsOf<OwnPoseOptions>(json.at("own_poses"));
    if (json.contains("detector"))
      recipe.detector = ChoiceFromJson<DetectorSource>(json.at("detector"));
    if (json.contains("edges")) recipe.edges = ChoiceFromJson<EdgeSource>(json.at("edges"));
    recipe.scorer = EnumFromName<ScorerKind>(json.at("scorer").get<std::string>());
    recipe.options = KnownOptions(json.at("options"));
    recipe.seed = UnsignedFromJson(json.at("seed"));
    const nlohmann::json& frames = json.at("frames");
    recipe.frames.begin = IntFromJson(frames.at("begin"));
    recipe.frames.step = IntFromJson(frames.at("step"));
    if (frames.contains("end")) recipe.frames.end = IntFromJson(frames.at("end"));
    if (json.contains("live_speed")) recipe.live_speed = json.at("live_speed").get<double>();
  } catch (const std::exception& error) {
    return Error{ErrorCode::kCorrupt,
                 std::string("its recipe cannot be read (") + error.what() + ")"};
  }
  return recipe;
}

}  // namespace plumbline
