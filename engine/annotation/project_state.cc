// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/project_state.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "engine/dataset/json_fields.h"

namespace plumbline {

Status CheckState(const ProjectState& state) {
  if (state.stage == WorkStage::kNew)
    return InvalidInput("a project is new until somebody says otherwise; that cannot be said");
  if (state.annotator.empty()) return InvalidInput("a state needs the name of an 'annotator'");
  if (state.reviewer == state.annotator)
    return InvalidInput("'" + state.annotator + "' handed it over; a second person reviews it");
  return {};
}

Result<ProjectState> NextState(const std::optional<ProjectState>& now, WorkStage stage,
                               const std::string& who, std::string note) {
  if (who.empty()) return InvalidInput("say who you are first (More, Annotator)");
  if (now && now->stage == stage)
    return InvalidInput("it is '" + std::string(NameOf(stage)) + "' already");
  ProjectState next{stage, who, "", std::move(note)};
  const bool judged = now && stage != WorkStage::kToReview && now->stage != WorkStage::kInWork;
  if (judged && now->annotator != who) {
    next.annotator = now->annotator;
    next.reviewer = who;
  } else if (judged && stage == WorkStage::kDone) {
    return InvalidInput("you handed it over yourself; a second person reviews it");
  }
  if (const Status good = CheckState(next); !good.ok()) return good.error();
  return next;
}

nlohmann::json StateToJson(const ProjectState& state) {
  nlohmann::json json = {{"stage", NameOf(state.stage)}, {"annotator", state.annotator}};
  if (!state.reviewer.empty()) json["reviewer"] = state.reviewer;
  if (!state.note.empty()) json["note"] = state.note;
  return json;
}

Result<ProjectState> StateFromJson(const nlohmann::json& json) {
  if (!json.is_object()) return InvalidInput("a state must be a JSON object");
  ProjectState state;
  const std::string stage = TextFromJson(json, "stage").value_or("");
  bool known = false;
  for (const WorkStage each : {WorkStage::kInWork, WorkStage::kToReview, WorkStage::kDone}) {
    if (stage != NameOf(each)) continue;
    state.stage = each;
    known = true;
  }
  if (!known)
    return InvalidInput("a state has a 'stage' that is none of in work, to review and done");
  state.annotator = TextFromJson(json, "annotator").value_or("");
  state.reviewer = TextFromJson(json, "reviewer").value_or("");
  state.note = TextFromJson(json, "note").value_or("");
  if (const Status good = CheckState(state); !good.ok()) return good.error();
  return state;
}

}  // namespace plumbline
