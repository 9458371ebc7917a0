// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine/annotation/annotation_document.h"

namespace plumbline {

struct AddInstance {
  AnnotatedInstance instance;
  std::optional<std::size_t> index;  ///< Position in the list; at the end where there is none.
};

struct RemoveInstance {
  std::string id;
};

/// Changes what is set; the rest stays.
struct ChangeInstance {
  std::string id;
  InstanceChange set;
};

/// A whole new belief about down and the floor: plane picks, typed numbers, a trajectory's gravity.
struct SetGravity {
  Eigen::Vector3d gravity_in_scan{0, 0, -1};
  std::optional<Eigen::Vector4d> floor_in_scan;
};

struct SetSceneAlignment {
  std::optional<Eigen::Isometry3d> scan_from_world;
};

struct SetInputs {
  std::string scan, models, sequence;
};

/// Cuts something out of the scan. What the crop does not say, up and the support, is filled in
/// from the document.
struct AddCrop {
  Crop crop;
  std::optional<std::size_t> index;  ///< Position in the list; at the end where there is none.
};

struct RemoveCrop {
  std::string id;
};

/// One more pair of points to register the sequence by.
struct AddPair {
  FramePick pair;
  std::optional<std::size_t> index;  ///< Position in the list; at the end where there is none.
};

struct RemovePair {
  std::size_t index = 0;
};

/// How far the work is, and who says so; nothing: nobody does.
struct SetState {
  std::optional<ProjectState> state;
};

/// A finding is all right; what was said of the same one before is forgotten.
struct AcceptFinding {
  AcceptedFinding accepted;
  std::optional<std::size_t> index;  ///< Position in the list; at the end where there is none.
};

/// It is open again.
struct ReopenFinding {
  std::string kind;
  std::vector<std::string> instances;
};

struct EditGroup;
using Edit = std::variant<AddInstance, RemoveInstance, ChangeInstance, SetGravity,
                          SetSceneAlignment, SetInputs, AddCrop, RemoveCrop, AddPair, RemovePair,
                          SetState, AcceptFinding, ReopenFinding, EditGroup>;

/// Several edits that are done and undone as one: an import, the acceptance of a run's drafts.
struct EditGroup {
  std::string label;
  std::vector<Edit> edits;
};

/// The crop with what it leaves open taken from the document: up, and the floor as its support.
/// Errors: kInvalidInput (the floor is not known; see CheckCrop).
Result<Crop> CompletedCrop(Crop crop, const AnnotationDocument& document);

/// Changes the document and returns the edit that takes it back exactly. Errors: kNotFound (no such
/// instance), kInvalidInput (an id that exists, a locked instance, numbers that are none); the
/// document is then unchanged.
Result<Edit> ApplyEdit(const Edit& edit, AnnotationDocument& document);

/// What a menu says: "Move chair_1".
std::string DescribeEdit(const Edit& edit);

/// {"edit": "add"|"remove"|"change"|"gravity"|"scene_alignment"|"inputs"|"crop"|
/// "remove_crop"|"pair"|"remove_pair"|"state"|"accept"|"reopen"|"group", ...}; the rest of
/// the keys as in the project file.
nlohmann::json EditToJson(const Edit& edit);
/// Errors: kInvalidInput.
Result<Edit> EditFromJson(const nlohmann::json& json);

}  // namespace plumbline
