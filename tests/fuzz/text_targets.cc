// SPDX-License-Identifier: Apache-2.0
// JSON in general, options, ranges: what comes in text and by the command line.
#include <array>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/options.h"
#include "engine/mapping/mapper_options.h"
#include "engine/mapping/option_changes.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/vio/own_pose_options.h"
#include "tests/fuzz/fuzz_targets.h"

namespace plumbline::fuzz {
namespace {

Status Json(std::string_view input) {
  const auto json = ReadJson(FileOf("any.json", input));
  if (!json.ok()) return json.error();
  (void)JsonText(*json, 2);
  return {};
}

Status Options(std::string_view input) {
  const auto json = ReadJson(FileOf("options.json", input));
  if (!json.ok()) return json.error();
  MapperOptions options;
  OwnPoseOptions own_poses;
  (void)OptionsFromJson(*json, own_poses);
  (void)KnownOptions(*json);
  if (const Status read = OptionsFromJson(*json, options); !read.ok()) return read;
  return OptionsFromJson(OptionsToJson(options), options);  // what is written is read again
}

Status OptionAssignment(std::string_view input) {
  try {  // as the command line checks its arguments before anything else
    (void)nlohmann::json(input).dump();
  } catch (const nlohmann::json::type_error&) {
    return InvalidInput("text that is not UTF-8");
  }
  MapperOptions options;
  return SetOption(input, options);
}

Status OptionChange(std::string_view input) {
  (void)DescribeOptionChanges(input);
  (void)OptionChangesFromFormat1(input);
  MapperOptions options;
  return ApplyOptionChanges(input, options);
}

Status Range(std::string_view input) { return StatusOf(ParseFrameRange(input)); }

constexpr std::array kTextTargets = {
    Target{"json", Json}, Target{"options", Options}, Target{"option_assignment", OptionAssignment},
    Target{"option_change", OptionChange}, Target{"frame_range", Range}};

}  // namespace

std::span<const Target> TextTargets() { return kTextTargets; }

}  // namespace plumbline::fuzz
