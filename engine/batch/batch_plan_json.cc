// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_plan.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/base/options.h"
#include "engine/batch/batch_figures.h"
#include "engine/mapping/mapper_options.h"
#include "engine/pipeline/run_recipe.h"

namespace plumbline {
namespace {

using nlohmann::json;

constexpr std::size_t kMostRuns = 1'000'000;
constexpr std::size_t kLongestName = 80;

/// What is wrong with a plan; caught where it is read.
struct PlanError {
  std::string what;
};

[[noreturn]] void Refuse(std::string what) { throw PlanError{std::move(what)}; }

void CheckKeys(const json& object, const std::string& where, std::vector<std::string> known) {
  if (!object.is_object()) Refuse(where + " must be a JSON object");
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      Refuse(fmt::format("{} has an unknown key '{}'; did you mean '{}'?", where, key,
                         NearestName(key, known)));
  }
}

std::string TextAt(const json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) return "";
  if (!found->is_string()) Refuse(fmt::format("'{}' of {} must be a text", key, where));
  auto text = found->get<std::string>();
  // Words of a command line end there.
  if (text.find('\0') != std::string::npos)
    Refuse(fmt::format("'{}' of {} has a zero byte in it", key, where));
  return text;
}

std::vector<std::string> WordsAt(const json& object, const char* key, const std::string& where) {
  std::vector<std::string> words;
  const auto found = object.find(key);
  if (found == object.end()) return words;
  if (!found->is_array()) Refuse(fmt::format("'{}' of {} must be a list of texts", key, where));
  for (const json& word : *found) {
    if (!word.is_string()) Refuse(fmt::format("'{}' of {} must be a list of texts", key, where));
    words.push_back(TextAt({{key, word}}, key, where));
  }
  return words;
}

double NumberFrom(const json& value, const std::string& what) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    Refuse(what + " must be a number, not " + value.dump());
  return value.get<double>();
}

/// An absolute path; empty stays empty.
std::filesystem::path Absolute(const std::filesystem::path& folder, const std::string& text) {
  return text.empty() ? std::filesystem::path() : (folder / text).lexically_normal();
}

/// Names become parts of the names of folders and rows of tables.
std::string CheckedName(std::string name, const std::string& what) {
  const auto bad = [](char c) { return static_cast<unsigned char>(c) < 32 || c == '/'; };
  if (name.empty() || name.size() > kLongestName || std::any_of(name.begin(), name.end(), bad))
    Refuse(fmt::format("the name '{}' of {} must have 1 to {} characters, none of them a slash",
                       name.substr(0, kLongestName), what, kLongestName));
  return name;
}

/// A value of JSON as a word of the command line.
std::string WordOf(const json& value, const std::string& what) {
  if (value.is_string()) return TextAt({{"value", value}}, "value", what);
  if (value.is_number() || value.is_boolean()) return value.dump();
  Refuse(what + " must be a number, a text, true or false, not " + value.dump());
}

std::uint64_t SeedFrom(std::string_view text, const std::string& where) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size() || seed >> 63 != 0)
    Refuse(fmt::format("a seed of {} must be a whole number from 0, not '{}'", where, text));
  return seed;
}

/// [0, 1, 4] or "0:10", the last not included, as with --frames.
std::vector<std::uint64_t> SeedsFrom(const json& value, const std::string& where) {
  std::vector<std::uint64_t> seeds;
  if (value.is_array()) {
    for (const json& seed : value) seeds.push_back(SeedFrom(seed.dump(), where));
  } else {
    const auto text = value.is_string() ? value.get<std::string>() : value.dump();
    const std::size_t colon = text.find(':');
    if (!value.is_string() || colon == std::string::npos)
      Refuse("the seeds of " + where + " must be a list, [0, 1, 2], or a range, \"0:3\"");
    const std::uint64_t first = SeedFrom(std::string_view(text).substr(0, colon), where);
    const std::uint64_t end = SeedFrom(std::string_view(text).substr(colon + 1), where);
    if (end < first || end - first > kMostRuns)
      Refuse(fmt::format("the seeds {} of {} are no range; write first:end", text, where));
    for (std::uint64_t seed = first; seed < end; ++seed) seeds.push_back(seed);
  }
  if (seeds.empty()) Refuse("there is no seed in those of " + where);
  if (std::set(seeds.begin(), seeds.end()).size() != seeds.size())
    Refuse("a seed of " + where + " is there twice");
  return seeds;
}

/// {"scene": "room", "imu": true} as --scene room --imu; a list of words as it is.
std::vector<std::string> SynthWords(const json& synth, const std::string& where) {
  if (synth.is_array()) return WordsAt({{"synth", synth}}, "synth", where);
  if (!synth.is_object())
    Refuse("'synth' of " + where + " must be an object, as {\"scene\": \"room\", \"seed\": 1}");
  std::vector<std::string> words;
  for (const auto& [key, value] : synth.items()) {
    if (value == json(false)) continue;
    words.push_back("--" + key);
    if (value == json(true)) continue;
    const json values = value.is_array() ? value : json::array({value});
    for (const json& one : values) words.push_back(WordOf(one, "'" + key + "' of " + where));
  }
  if (words.empty()) Refuse("'synth' of " + where + " says nothing; name a scene");
  return words;
}

void AddSynthetic(const json& entry, const std::string& where, BatchPlan& plan) {
  PlannedSequence sequence;
  sequence.name = CheckedName(TextAt(entry, "name", where), where);
  sequence.synth = SynthWords(entry.at("synth"), where);
  const auto has = [&](const char* word) {
    return std::find(sequence.synth.begin(), sequence.synth.end(), word) != sequence.synth.end();
  };
  if (has("--out")) Refuse("'synth' of " + where + " has 'out'; the batch chooses the folder");
  const auto seeds = entry.find("seeds");
  if (seeds == entry.end()) {
    plan.sequences.push_back(sequence);
    return;
  }
  if (has("--seed")) Refuse(where + " has seeds, and a seed in its 'synth' as well");
  for (const std::uint64_t seed : SeedsFrom(*seeds, where)) {
    PlannedSequence one = sequence;
    one.name += "-" + std::to_string(seed);
    one.synth.insert(one.synth.end(), {"--seed", std::to_string(seed)});
    plan.sequences.push_back(std::move(one));
  }
}

void AddSequence(const json& given, const std::filesystem::path& folder, BatchPlan& plan) {
  const std::string where = "sequence " + std::to_string(plan.sequences.size() + 1);
  const json entry = given.is_string() ? json{{"path", given}} : given;
  if (entry.is_object() && entry.contains("synth")) {
    CheckKeys(entry, where, {"name", "synth", "seeds"});
    return AddSynthetic(entry, where, plan);
  }
  CheckKeys(entry, where, {"name", "path", "ground_truth", "models", "scene", "synth", "seeds"});
  if (entry.contains("seeds")) Refuse("'seeds' of " + where + " goes with 'synth'");
  PlannedSequence sequence;
  sequence.path = Absolute(folder, TextAt(entry, "path", where));
  if (sequence.path.empty()) Refuse(where + " has neither 'path' nor 'synth'");
  if (!sequence.path.has_filename()) sequence.path = sequence.path.parent_path();
  sequence.name = TextAt(entry, "name", where);
  if (sequence.name.empty()) sequence.name = sequence.path.filename().string();
  sequence.name = CheckedName(sequence.name, where);
  sequence.ground_truth = Absolute(folder, TextAt(entry, "ground_truth", where));
  sequence.models = Absolute(folder, TextAt(entry, "models", where));
  sequence.scene = Absolute(folder, TextAt(entry, "scene", where));
  plan.sequences.push_back(std::move(sequence));
}

/// A file of the plan's folder, or a name that `run` knows.
std::string FileOrName(const std::filesystem::path& folder, const std::string& text) {
  std::error_code error;
  const std::filesystem::path file = Absolute(folder, text);
  return std::filesystem::exists(file, error) ? file.string() : text;
}

/// Options of `set` as words; of this program they are checked here.
void AddSettings(const json& entry, const char* key, const char* word, PlannedRecipe& recipe) {
  const auto found = entry.find(key);
  if (found == entry.end()) return;
  const std::string where = fmt::format("'{}' of recipe '{}'", key, recipe.name);
  if (!found->is_object()) Refuse(where + " must be an object of options and values");
  if (recipe.program.empty()) {
    MapperOptions mapper;
    OwnPoseOptions poses;
    const Status status = std::string_view(key) == "set" ? OptionsFromJson(*found, mapper)
                                                         : OptionsFromJson(*found, poses);
    if (!status.ok()) Refuse(where + ": " + status.error().message);
  }
  for (const auto& [name, value] : found->items())
    recipe.words.insert(recipe.words.end(), {word, name + "=" + WordOf(value, where)});
}

void AddRecipe(const json& entry, const std::filesystem::path& folder, BatchPlan& plan) {
  const std::string where = "recipe " + std::to_string(plan.recipes.size() + 1);
  CheckKeys(entry, where,
            {"name", "program", "preset", "options", "set", "set_poses", "detector", "edges",
             "poses", "scorer", "frames", "models", "arguments"});
  PlannedRecipe recipe;
  recipe.name = CheckedName(TextAt(entry, "name", where), where);
  recipe.program = Absolute(folder, TextAt(entry, "program", where));
  const auto add = [&](const char* key, const std::string& value) {
    if (!value.empty()) recipe.words.insert(recipe.words.end(), {std::string("--") + key, value});
  };
  for (const char* key : {"preset", "scorer", "frames"}) add(key, TextAt(entry, key, where));
  for (const char* key : {"detector", "edges", "poses"}) {
    const std::string text = TextAt(entry, key, where);
    if (!text.empty()) add(key, FileOrName(folder, text));
  }
  for (const char* key : {"options", "models"})
    add(key, Absolute(folder, TextAt(entry, key, where)).string());
  if (const std::string frames = TextAt(entry, "frames", where); !frames.empty()) {
    if (const auto range = ParseFrameRange(frames); !range.ok())
      Refuse("'frames' of " + where + ": " + range.error().message);
  }
  AddSettings(entry, "set", "--set", recipe);
  AddSettings(entry, "set_poses", "--set-poses", recipe);
  for (std::string& word : WordsAt(entry, "arguments", where))
    recipe.words.push_back(std::move(word));
  for (const char* own : {"--out", "--json", "--seed", "--resume", "--fork", "--live"}) {
    if (std::find(recipe.words.begin(), recipe.words.end(), own) != recipe.words.end())
      Refuse(fmt::format("'arguments' of {} have {}, which is the batch's to choose", where, own));
  }
  plan.recipes.push_back(std::move(recipe));
}

std::vector<double> RangeFrom(const json& value, const std::string& where) {
  CheckKeys(value, where, {"from", "to", "steps", "log"});
  for (const char* key : {"from", "to", "steps"}) {
    if (!value.contains(key)) Refuse(where + " has no '" + key + "'");
  }
  const double from = NumberFrom(value["from"], "'from' of " + where);
  const double to = NumberFrom(value["to"], "'to' of " + where);
  const double steps = NumberFrom(value["steps"], "'steps' of " + where);
  const bool log = value.value("log", json(false)) == json(true);
  if (!(from < to) || (log && from <= 0) || steps != std::floor(steps) || steps < 2 || steps > 1000)
    Refuse(where + " must rise from 'from' to 'to' (above 0 with 'log') in 2 to 1000 'steps'");
  std::vector<double> values;
  for (int i = 0; i < static_cast<int>(steps); ++i) {
    const double share = i / (steps - 1);
    const double at = log ? from * std::pow(to / from, share) : from + (to - from) * share;
    // What a reader would have written: 0.3, not 0.30000000000000004.
    values.push_back(std::stod(fmt::format("{:.6g}", i == 0 ? from : share == 1 ? to : at)));
  }
  return values;
}

/// The value as the option takes it; whole for options that are whole.
double CheckedValue(const std::string& option, double value, const std::string& where) {
  MapperOptions options;
  Status status = OptionsFromJson({{option, value}}, options);
  const auto whole = static_cast<std::int64_t>(std::clamp(std::round(value), -1e15, 1e15));
  if (!status.ok() && OptionsFromJson({{option, whole}}, options).ok())
    return static_cast<double>(whole);
  if (!status.ok()) Refuse(where + ": " + status.error().message);
  return value;
}

void AddSweep(const json& sweep, BatchPlan& plan) {
  if (!sweep.is_object() || sweep.empty() || sweep.size() > 2)
    Refuse("'sweep' must name one or two options, as {\"beta\": [0, 1, 2]}");
  for (const auto& [option, given] : sweep.items()) {
    const std::string where = "'" + option + "' of 'sweep'";
    for (const PlannedRecipe& recipe : plan.recipes) {
      for (const std::string& word : recipe.words) {
        if (word.starts_with(option + "="))
          Refuse(fmt::format("{} is also set by the recipe '{}'", where, recipe.name));
      }
    }
    std::vector<double> values;
    if (given.is_array()) {
      for (const json& value : given) values.push_back(NumberFrom(value, where));
    } else {
      values = RangeFrom(given, where);
    }
    for (double& value : values) value = CheckedValue(option, value, where);
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    if (values.size() < 2) Refuse(where + " needs two values or more");
    plan.sweep.push_back({option, std::move(values)});
  }
}

void ReadEvaluation(const json& given, PlannedEvaluation& evaluation) {
  const std::string where = "'evaluate'";
  CheckKeys(given, where, {"samples", "single_frames", "align", "ignore_categories"});
  const auto count = [&](const char* key, int least, int most, int& value) {
    if (!given.contains(key)) return;
    const double number = NumberFrom(given[key], fmt::format("'{}' of {}", key, where));
    if (number != std::floor(number) || number < least || number > most)
      Refuse(
          fmt::format("'{}' of {} must be a whole number from {} to {}", key, where, least, most));
    value = static_cast<int>(number);
  };
  count("samples", 1, 100'000'000, evaluation.samples);
  count("single_frames", 0, 1'000'000, evaluation.single_frames);
  evaluation.align = TextAt(given, "align", where);
  evaluation.ignored_categories = WordsAt(given, "ignore_categories", where);
}

void CheckGate(const std::vector<std::string>& gate) {
  std::vector<std::string> known;
  for (const BatchFigure& figure : BatchFigures()) {
    if (figure.better != 0) known.push_back(figure.name);
  }
  for (const std::string& name : gate) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      Refuse(
          fmt::format("'gate' names '{}', which is no figure that can be better or worse; did "
                      "you mean '{}'?",
                      name, NearestName(name, known)));
  }
}

void CheckNames(const BatchPlan& plan) {
  const auto check = [](const auto& things, const char* what) {
    std::set<std::string> names;
    for (const auto& thing : things) {
      if (!names.insert(thing.name).second)
        Refuse(fmt::format("two {} are named '{}'; give one another 'name'", what, thing.name));
    }
  };
  check(plan.sequences, "sequences");
  check(plan.recipes, "recipes");
}

BatchPlan PlanFrom(const json& given, const std::filesystem::path& folder) {
  CheckKeys(
      given, "the plan",
      {"name", "sequences", "recipes", "seeds", "sweep", "evaluate", "timeout_s", "gate", "slurm"});
  BatchPlan plan;
  plan.name = TextAt(given, "name", "the plan");
  if (!given.contains("sequences") || !given["sequences"].is_array() || given["sequences"].empty())
    Refuse("the plan needs 'sequences', a list of folders or of what 'synth' shall make");
  for (const json& sequence : given["sequences"]) AddSequence(sequence, folder, plan);
  const json recipes = given.value("recipes", json::array({{{"name", "default"}}}));
  if (!recipes.is_array() || recipes.empty()) Refuse("'recipes' must be a list of objects");
  for (const json& recipe : recipes) AddRecipe(recipe, folder, plan);
  plan.seeds = SeedsFrom(given.value("seeds", json::array({0})), "the plan");
  if (given.contains("sweep")) AddSweep(given["sweep"], plan);
  if (given.contains("evaluate")) ReadEvaluation(given["evaluate"], plan.evaluation);
  if (given.contains("timeout_s")) {
    plan.timeout_s = NumberFrom(given["timeout_s"], "'timeout_s'");
    if (*plan.timeout_s <= 0) Refuse("'timeout_s' must be above 0");
  }
  plan.gate = WordsAt(given, "gate", "the plan");
  plan.slurm = WordsAt(given, "slurm", "the plan");
  CheckGate(plan.gate);
  CheckNames(plan);
  const std::size_t runs =
      plan.sequences.size() * plan.recipes.size() * plan.seeds.size() * PointsOf(plan).size();
  if (runs > kMostRuns) Refuse(fmt::format("{} runs are more than {}", runs, kMostRuns));
  return plan;
}

}  // namespace

Result<BatchPlan> BatchPlanFromJson(const json& given, const std::filesystem::path& folder) {
  try {
    return PlanFrom(given, folder);
  } catch (const PlanError& error) {
    return InvalidInput(error.what);
  }
}

}  // namespace plumbline
