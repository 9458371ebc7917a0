// SPDX-License-Identifier: Apache-2.0
#include "ui/files/script_file.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/base/files.h"
#include "ui/files/kept_value.h"
#include "ui/files/window_settings.h"

namespace plumbline {
namespace {

/// Each takes a frame of the window: a script that says more has a slip in it.
constexpr int kMostTimes = 100000;
/// Shares of a widget, also outside of it.
constexpr double kFarthestShare = 1000;

/// What the value of a key of a step has to be.
struct StepKey {
  const char* key;
  const char* is;
  bool (*fits)(const nlohmann::json& value);
};

bool IsText(const nlohmann::json& value) { return value.is_string(); }
bool IsCount(const nlohmann::json& value) {
  int count = 0;
  return TakeValue(value, count) && count >= -kMostTimes && count <= kMostTimes;
}
bool IsSwitch(const nlohmann::json& value) { return value.is_boolean(); }
bool IsPair(const nlohmann::json& value) {
  return value.is_array() && value.size() == 2 &&
         std::all_of(value.begin(), value.end(), [](const nlohmann::json& number) {
           return number.is_number() && std::abs(number.get<double>()) <= kFarthestShare;
         });
}
bool IsSize(const nlohmann::json& value) {
  return value.is_array() && value.size() == 2 &&
         std::all_of(value.begin(), value.end(), [](const nlohmann::json& side) {
           int pixels = 0;
           return TakeValue(side, pixels) && pixels > 0 && pixels <= kLargestWindow;
         });
}
bool AreTexts(const nlohmann::json& value) {
  return value.is_array() && std::all_of(value.begin(), value.end(), IsText);
}

constexpr const char* kWhole = "a whole number of at most 100000";
constexpr StepKey kStepKeys[] = {
    {"key", "a text", IsText},
    {"text", "a text", IsText},
    {"click", "a text", IsText},
    {"double_click", "a text", IsText},
    {"drag", "a text", IsText},
    {"wheel", "a text", IsText},
    {"hover", "a text", IsText},
    {"button", "a text", IsText},
    {"screenshot", "a text", IsText},
    {"of", "a text", IsText},
    {"dump_state", "a text", IsText},
    {"open", "a text", IsText},
    {"drop", "a list of texts", AreTexts},
    {"times", kWhole, IsCount},
    {"amount", kWhole, IsCount},
    {"wait_frames", kWhole, IsCount},
    {"timeout_s", "a number", [](const nlohmann::json& value) { return value.is_number(); }},
    {"shift", "true or false", IsSwitch},
    {"control", "true or false", IsSwitch},
    {"alt", "true or false", IsSwitch},
    {"at", "two numbers of at most 1000", IsPair},
    {"from", "two numbers of at most 1000", IsPair},
    {"to", "two numbers of at most 1000", IsPair},
    {"resize", "two whole numbers of pixels, at most 16384", IsSize},
    {"wait_for", "an object", [](const nlohmann::json& value) { return value.is_object(); }}};

/// Why a step cannot be done whatever the window shows; "": it may be.
std::string ProblemOf(const nlohmann::json& step) {
  if (!step.is_object() || step.empty()) return "is " + step.dump() + ", but must be an object";
  for (const StepKey& known : kStepKeys) {
    const auto value = step.find(known.key);
    if (value != step.end() && !known.fits(*value))
      return std::string("\"") + known.key + "\" must be " + known.is + ", but is " + value->dump();
  }
  if (step.contains("drag") && !step.contains("to")) return "\"drag\" needs \"to\"";
  return "";
}

}  // namespace

Result<std::vector<nlohmann::json>> ReadScript(const std::filesystem::path& file) {
  const auto content = ReadJson(file);
  if (!content.ok()) return content.error();
  const auto steps = content->find("steps");
  if (steps == content->end() || !steps->is_array()) {
    return Error{ErrorCode::kInvalidInput, file.string() + ": a script is {\"steps\": [...]}"};
  }
  int number = 0;
  for (const nlohmann::json& step : *steps) {
    ++number;
    if (const std::string problem = ProblemOf(step); !problem.empty()) {
      return Error{ErrorCode::kInvalidInput,
                   file.string() + ": step " + std::to_string(number) + ": " + problem};
    }
  }
  return std::vector<nlohmann::json>(steps->begin(), steps->end());
}

}  // namespace plumbline
