// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_edit.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace plumbline {
namespace {

bool IsRigid(const Eigen::Isometry3d& pose) {
  return pose.matrix().allFinite() &&
         (pose.linear() * pose.linear().transpose() - Eigen::Matrix3d::Identity())
                 .cwiseAbs()
                 .maxCoeff() < 1e-6 &&
         pose.linear().determinant() > 0;
}

Result<std::size_t> IndexOf(const AnnotationDocument& document, const std::string& id) {
  for (std::size_t i = 0; i < document.instances.size(); ++i) {
    if (document.instances[i].id == id) return i;
  }
  return Error{ErrorCode::kNotFound, "there is no instance '" + id + "'"};
}

Error Locked(const std::string& id) {
  return InvalidInput("instance '" + id + "' is locked; unlock it first");
}

constexpr double kSmallestScale = 0.1, kLargestScale = 10;

bool IsScale(double scale) { return scale >= kSmallestScale && scale <= kLargestScale; }

Error NoScale(const std::string& id) {
  return InvalidInput("the scale of '" + id + "' must be between 0.1 and 10");
}

Result<Edit> Apply(const AddInstance& edit, AnnotationDocument& document) {
  const AnnotatedInstance& instance = edit.instance;
  if (instance.id.empty() || instance.model.empty()) {
    return InvalidInput("an instance needs an id and a model");
  }
  if (document.Find(instance.id))
    return InvalidInput("there is an instance '" + instance.id + "' already");
  if (!IsRigid(instance.scan_from_object)) {
    return InvalidInput("the pose of '" + instance.id + "' is not a rigid transform");
  }
  if (!IsScale(instance.scale)) return NoScale(instance.id);
  const std::size_t index =
      std::min(edit.index.value_or(document.instances.size()), document.instances.size());
  document.instances.insert(document.instances.begin() + static_cast<std::ptrdiff_t>(index),
                            instance);
  return Edit(RemoveInstance{instance.id});
}

Result<Edit> Apply(const RemoveInstance& edit, AnnotationDocument& document) {
  const Result<std::size_t> index = IndexOf(document, edit.id);
  if (!index) return index.error();
  if (document.instances[*index].locked) return Locked(edit.id);
  AddInstance back{document.instances[*index], *index};
  document.instances.erase(document.instances.begin() + static_cast<std::ptrdiff_t>(*index));
  return Edit(std::move(back));
}

/// What was said of an object is said of it under its new name. Of one that is gone and had that
/// name it is not said any more by this name; undo gives both theirs back.
void RenameAccepted(const std::string& from, const std::string& to, AnnotationDocument& document) {
  for (AcceptedFinding& accepted : document.accepted) {
    for (AcceptedFinding::Object& object : accepted.objects) {
      if (object.id == from)
        object.id = to;
      else if (object.id == to)
        object.id = from;
    }
  }
}

Result<Edit> Apply(const ChangeInstance& edit, AnnotationDocument& document) {
  const Result<std::size_t> index = IndexOf(document, edit.id);
  if (!index) return index.error();
  AnnotatedInstance& instance = document.instances[*index];
  const InstanceChange& set = edit.set;
  if (instance.locked && !set.locked &&
      (set.scan_from_object || set.model || set.id || set.scale)) {
    return Locked(edit.id);
  }
  if (set.scan_from_object && !IsRigid(*set.scan_from_object)) {
    return InvalidInput("the new pose of '" + edit.id + "' is not a rigid transform");
  }
  if (set.id && (set.id->empty() || (*set.id != edit.id && document.Find(*set.id)))) {
    return InvalidInput("'" + edit.id + "' cannot be called '" + *set.id +
                        "': names must be unique and not empty");
  }
  if (set.seconds_spent && !(*set.seconds_spent >= 0 && std::isfinite(*set.seconds_spent))) {
    return InvalidInput("the time spent on '" + edit.id + "' must not be negative");
  }
  if (set.model && set.model->empty()) return InvalidInput("'" + edit.id + "' needs a model");
  if (set.scale && !IsScale(*set.scale)) return NoScale(edit.id);
  if (set.id) RenameAccepted(edit.id, *set.id, document);
  ChangeInstance back;
  back.id = set.id.value_or(edit.id);
  back.set = ChangeFields(set, instance);
  return Edit(std::move(back));
}

Result<Edit> Apply(const SetGravity& edit, AnnotationDocument& document) {
  const double norm = edit.gravity_in_scan.norm();
  if (!(std::abs(norm - 1) < 1e-6)) return InvalidInput("gravity must be a unit vector");
  if (edit.floor_in_scan) {
    const Eigen::Vector4d& floor = *edit.floor_in_scan;
    if (!floor.allFinite() || !((floor.head<3>() + edit.gravity_in_scan).norm() < 1e-4)) {
      return InvalidInput("the floor's normal must be up, against gravity");
    }
  }
  SetGravity back{document.gravity_in_scan, document.floor_in_scan};
  document.gravity_in_scan = edit.gravity_in_scan;
  document.floor_in_scan = edit.floor_in_scan;
  return Edit(std::move(back));
}

Result<Edit> Apply(const SetSceneAlignment& edit, AnnotationDocument& document) {
  if (edit.scan_from_world && !IsRigid(*edit.scan_from_world)) {
    return InvalidInput("the alignment of sequence and scan is not a rigid transform");
  }
  return Edit(SetSceneAlignment{std::exchange(document.scan_from_world, edit.scan_from_world)});
}

Result<Edit> Apply(const SetInputs& edit, AnnotationDocument& document) {
  SetInputs back{document.scan, document.models, document.sequence};
  document.scan = edit.scan;
  document.models = edit.models;
  document.sequence = edit.sequence;
  return Edit(std::move(back));
}

Result<Edit> Apply(const AddCrop& edit, AnnotationDocument& document) {
  Result<Crop> crop = CompletedCrop(edit.crop, document);
  if (!crop) return crop.error();
  if (document.FindCrop(crop->id))
    return InvalidInput("there is a crop '" + crop->id + "' already");
  Edit back = RemoveCrop{crop->id};
  const std::size_t index =
      std::min(edit.index.value_or(document.crops.size()), document.crops.size());
  document.crops.insert(document.crops.begin() + static_cast<std::ptrdiff_t>(index),
                        std::move(*crop));
  return back;
}

Result<Edit> Apply(const RemoveCrop& edit, AnnotationDocument& document) {
  const auto found = std::find_if(document.crops.begin(), document.crops.end(),
                                  [&](const Crop& crop) { return crop.id == edit.id; });
  if (found == document.crops.end()) {
    return Error{ErrorCode::kNotFound, "there is no crop '" + edit.id + "'"};
  }
  AddCrop back{std::move(*found), static_cast<std::size_t>(found - document.crops.begin())};
  document.crops.erase(found);
  return Edit(std::move(back));
}

Result<Edit> Apply(const AddPair& edit, AnnotationDocument& document) {
  if (!edit.pair.in_scan.allFinite() || !edit.pair.pixel.allFinite() || edit.pair.frame < 0) {
    return InvalidInput("a pair needs a point of the scan and a pixel of a frame");
  }
  const std::size_t index =
      std::min(edit.index.value_or(document.pairs.size()), document.pairs.size());
  document.pairs.insert(document.pairs.begin() + static_cast<std::ptrdiff_t>(index), edit.pair);
  return Edit(RemovePair{index});
}

Result<Edit> Apply(const RemovePair& edit, AnnotationDocument& document) {
  if (edit.index >= document.pairs.size()) {
    return Error{ErrorCode::kNotFound, "there is no pair " + std::to_string(edit.index + 1)};
  }
  const auto found = document.pairs.begin() + static_cast<std::ptrdiff_t>(edit.index);
  AddPair back{*found, edit.index};
  document.pairs.erase(found);
  return Edit(back);
}

Result<Edit> Apply(const SetState& edit, AnnotationDocument& document) {
  if (edit.state) {
    if (const Status good = CheckState(*edit.state); !good.ok()) return good.error();
  }
  return Edit(SetState{std::exchange(document.state, edit.state)});
}

using AcceptedList = std::vector<AcceptedFinding>;

AcceptedList::iterator FindAccepted(AnnotationDocument& document, const std::string& kind,
                                    const std::vector<std::string>& ids) {
  return std::find_if(document.accepted.begin(), document.accepted.end(),
                      [&](const AcceptedFinding& accepted) { return accepted.IsAbout(kind, ids); });
}

Result<Edit> Apply(const ReopenFinding& edit, AnnotationDocument& document) {
  const auto found = FindAccepted(document, edit.kind, edit.instances);
  if (found == document.accepted.end()) {
    return Error{ErrorCode::kNotFound, "no finding '" + edit.kind + "' of these was accepted"};
  }
  AcceptFinding back{std::move(*found),
                     static_cast<std::size_t>(found - document.accepted.begin())};
  document.accepted.erase(found);
  return Edit(std::move(back));
}

Result<Edit> Apply(const AcceptFinding& edit, AnnotationDocument& document) {
  const AcceptedFinding& accepted = edit.accepted;
  if (accepted.kind.empty() || accepted.objects.empty()) {
    return InvalidInput("only a finding about objects can be accepted");
  }
  std::vector<std::string> ids;
  for (const AcceptedFinding::Object& object : accepted.objects) ids.push_back(object.id);
  const auto known = FindAccepted(document, accepted.kind, ids);
  if (known != document.accepted.end()) {
    return Edit(AcceptFinding{std::exchange(*known, accepted), std::nullopt});
  }
  const std::size_t index =
      std::min(edit.index.value_or(document.accepted.size()), document.accepted.size());
  document.accepted.insert(document.accepted.begin() + static_cast<std::ptrdiff_t>(index),
                           accepted);
  return Edit(ReopenFinding{accepted.kind, std::move(ids)});
}

Result<Edit> Apply(const EditGroup& group, AnnotationDocument& document) {
  AnnotationDocument changed = document;
  EditGroup back{group.label, {}};
  for (const Edit& edit : group.edits) {
    Result<Edit> undo = ApplyEdit(edit, changed);
    if (!undo) return undo.error();
    back.edits.push_back(std::move(*undo));
  }
  std::reverse(back.edits.begin(), back.edits.end());
  document = std::move(changed);
  return Edit(std::move(back));
}

/// A kind of finding as it is said.
std::string WordsOf(std::string kind) {
  if (kind == "low_agreement") return "off the edges";
  if (kind == "unknown_model") return "of an unknown model";
  if (kind == "duplicate") return "a duplicate";
  std::replace(kind.begin(), kind.end(), '_', ' ');
  return kind;
}

std::string Describe(const AddInstance& edit) { return "Add " + edit.instance.id; }
std::string Describe(const RemoveInstance& edit) { return "Remove " + edit.id; }
std::string Describe(const ChangeInstance& edit) {
  if (edit.set.id) return "Rename " + edit.id + " to " + *edit.set.id;
  if (edit.set.scan_from_object) return "Move " + edit.id;
  if (edit.set.scale) return "Scale " + edit.id;
  if (edit.set.model) return "Change the model of " + edit.id;
  return "Change " + edit.id;
}
std::string Describe(const SetGravity&) { return "Set gravity"; }
std::string Describe(const SetSceneAlignment&) { return "Align sequence and scan"; }
std::string Describe(const SetInputs&) { return "Choose scan, models and sequence"; }
std::string Describe(const AddCrop& edit) { return "Cut out " + edit.crop.id; }
std::string Describe(const RemoveCrop& edit) { return "Forget the crop " + edit.id; }
std::string Describe(const AddPair& edit) {
  return "Pick a pair in frame " + std::to_string(edit.pair.frame);
}
std::string Describe(const RemovePair& edit) {
  return "Remove pair " + std::to_string(edit.index + 1);
}
std::string Describe(const SetState& edit) {
  if (!edit.state) return "Forget how far it is";
  switch (edit.state->stage) {
    case WorkStage::kToReview:
      return "Hand it over for review";
    case WorkStage::kDone:
      return "Say that it is done";
    default:
      return "Take it back to work";
  }
}
std::string Describe(const AcceptFinding& edit) {
  return "Accept that " + edit.accepted.objects.front().id + " is " + WordsOf(edit.accepted.kind);
}
std::string Describe(const ReopenFinding& edit) {
  return "Reopen that " + (edit.instances.empty() ? "it" : edit.instances.front()) + " is " +
         WordsOf(edit.kind);
}
std::string Describe(const EditGroup& group) { return group.label; }

}  // namespace

Result<Crop> CompletedCrop(Crop crop, const AnnotationDocument& document) {
  if (!crop.up_in_scan) crop.up_in_scan = -document.gravity_in_scan;
  if (crop.without_support && !crop.support_in_scan) crop.support_in_scan = document.floor_in_scan;
  if (crop.without_support && !crop.support_in_scan) {
    return InvalidInput(
        "what '" + crop.id +
        "' stands on is not known; find the floor first, or say which plane it is, or "
        "keep it");
  }
  if (const Status good = CheckCrop(crop); !good.ok()) return good.error();
  return crop;
}

Result<Edit> ApplyEdit(const Edit& edit, AnnotationDocument& document) {
  return std::visit([&](const auto& chosen) { return Apply(chosen, document); }, edit);
}

std::string DescribeEdit(const Edit& edit) {
  return std::visit([](const auto& chosen) { return Describe(chosen); }, edit);
}

}  // namespace plumbline
