// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/options.h"
#include "engine/base/result.h"

namespace plumbline {

/// How far the annotation of a scan is.
enum class WorkStage { kNew, kInWork, kToReview, kDone };
template <>
struct EnumNames<WorkStage> {
  static constexpr std::string_view names[] = {"new", "in work", "to review", "done"};
};
inline std::string_view NameOf(WorkStage stage) {
  return EnumNames<WorkStage>::names[static_cast<std::size_t>(stage)];
}

/// What people said of it last.
struct ProjectState {
  WorkStage stage = WorkStage::kInWork;  ///< Never kNew: that nobody says.
  std::string annotator;                 ///< Who handed it over, or said that it is done.
  std::string reviewer;                  ///< Who then judged it; "": nobody (yet).
  std::string note;                      ///< Of the one who spoke last.

  bool operator==(const ProjectState&) const = default;
};

/// What becomes of a state when `who` says so. A second person reviews: nobody ends the review of
/// what they handed over. Errors: kInvalidInput (that, `who` is empty, `stage` is kNew or the
/// same).
Result<ProjectState> NextState(const std::optional<ProjectState>& now, WorkStage stage,
                               const std::string& who, std::string note);

nlohmann::json StateToJson(const ProjectState& state);
/// Errors: kInvalidInput, also where annotator and reviewer are one.
Result<ProjectState> StateFromJson(const nlohmann::json& json);
/// Errors: kInvalidInput.
Status CheckState(const ProjectState& state);

}  // namespace plumbline
