// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/reopening.h"

#include <algorithm>
#include <utility>

namespace plumbline {
namespace {

bool ChangesTheWork(const Edit& edit) {
  if (const auto* group = std::get_if<EditGroup>(&edit))
    return std::any_of(group->edits.begin(), group->edits.end(), ChangesTheWork);
  if (const auto* change = std::get_if<ChangeInstance>(&edit)) {
    const InstanceChange& set = change->set;
    return set.id || set.model || set.category || set.scan_from_object || set.fine || set.note ||
           set.annotator || set.may_tilt || set.scale || set.may_scale;
  }
  return std::holds_alternative<AddInstance>(edit) ||
         std::holds_alternative<RemoveInstance>(edit) || std::holds_alternative<SetGravity>(edit) ||
         std::holds_alternative<SetSceneAlignment>(edit) || std::holds_alternative<AddCrop>(edit) ||
         std::holds_alternative<RemoveCrop>(edit);
}

bool SetsState(const Edit& edit) {
  if (const auto* group = std::get_if<EditGroup>(&edit))
    return std::any_of(group->edits.begin(), group->edits.end(), SetsState);
  return std::holds_alternative<SetState>(edit);
}

}  // namespace

Edit WithReopening(const Edit& edit, const AnnotationDocument& document, const std::string& who) {
  if (document.Stage() != WorkStage::kDone || !ChangesTheWork(edit) || SetsState(edit)) return edit;
  ProjectState state{WorkStage::kInWork, who.empty() ? document.state->annotator : who, "",
                     "edited after it was done"};
  return EditGroup{DescribeEdit(edit), {edit, SetState{std::move(state)}}};
}

}  // namespace plumbline
