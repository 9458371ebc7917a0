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

Result<Edit> Apply(const ChangeInstance& edit, AnnotationDocument& document) {
  const Result<std::size_t> index = IndexOf(document, edit.id);
  if (!index) return index.error();
  AnnotatedInstance& instance = document.instances[*index];
  const InstanceChange& set = edit.set;
  if (instance.locked && !set.locked && (set.scan_from_object || set.model || set.id)) {
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

std::string Describe(const AddInstance& edit) { return "Add " + edit.instance.id; }
std::string Describe(const RemoveInstance& edit) { return "Remove " + edit.id; }
std::string Describe(const ChangeInstance& edit) {
  if (edit.set.id) return "Rename " + edit.id + " to " + *edit.set.id;
  if (edit.set.scan_from_object) return "Move " + edit.id;
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
