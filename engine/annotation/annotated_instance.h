// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// `value` for a field that holds one, nothing for a field that is optional.
template <template <typename> typename Field, typename T>
Field<T> Initially(T value) {
  if constexpr (std::is_same_v<Field<T>, T>) {
    return value;
  } else {
    return {};
  }
}

/// What is known of one object that somebody placed. The project file, the journal, edits and their
/// undo, commands and the window all hold these fields: a new one is a line here and one in
/// VisitInstance. `Field` is what each is wrapped in.
template <template <typename> typename Field>
struct InstanceFields {
  Field<std::string> id;  ///< Unique in the document.
  Field<std::string> model;
  Field<std::string> category;  ///< COCO name.
  Field<Eigen::Isometry3d> scan_from_object =
      Initially<Field>(Eigen::Isometry3d(Eigen::Isometry3d::Identity()));
  Field<bool> fine = Initially<Field>(true);  ///< quality "fine" (else "coarse")
  Field<std::string> note;
  Field<std::string> annotator;
  Field<double> seconds_spent = Initially<Field>(0.0);
  Field<bool> hidden = Initially<Field>(false);  ///< In the window only.
  Field<bool> locked =
      Initially<Field>(false);  ///< Refuses changes of pose and model, and removal.
  Field<bool> may_tilt = Initially<Field>(false);  ///< It does not stand upright, and is meant so.
  /// The object is this much as large as its model, which is scaled before it is posed.
  Field<double> scale = Initially<Field>(1.0);
  Field<bool> may_scale = Initially<Field>(false);  ///< `scale` is for Refine to find.
};
using AnnotatedInstance = InstanceFields<std::type_identity_t>;
/// What is set changes, the rest stays; `id` renames it.
using InstanceChange = InstanceFields<std::optional>;

/// How a field is written in a project and its journal.
struct InstanceField {
  enum class Written { kRequired, kAlways, kUnlessDefault };
  std::string_view key;
  Written written = Written::kUnlessDefault;
};

/// Calls visit(InstanceField, field of the first, field of the second ...) for every field of one
/// or more InstanceFields.
template <typename Visitor, typename... Instances>
void VisitInstance(Visitor&& visit, Instances&&... of) {
  using enum InstanceField::Written;
  visit(InstanceField{"id", kRequired}, of.id...);
  visit(InstanceField{"model", kRequired}, of.model...);
  visit(InstanceField{"category", kAlways}, of.category...);
  visit(InstanceField{"quality", kAlways}, of.fine...);
  visit(InstanceField{"scan_from_object", kRequired}, of.scan_from_object...);
  visit(InstanceField{"annotator", kAlways}, of.annotator...);
  visit(InstanceField{"seconds_spent", kAlways}, of.seconds_spent...);
  visit(InstanceField{"note"}, of.note...);
  visit(InstanceField{"hidden"}, of.hidden...);
  visit(InstanceField{"locked"}, of.locked...);
  visit(InstanceField{"may_tilt"}, of.may_tilt...);
  visit(InstanceField{"scale"}, of.scale...);
  visit(InstanceField{"may_scale"}, of.may_scale...);
}

/// Returns the change that takes it back exactly.
InstanceChange ChangeFields(const InstanceChange& change, AnnotatedInstance& instance);

nlohmann::json InstanceToJson(const AnnotatedInstance& instance);
/// Unknown keys are ignored. Errors: kInvalidInput, what is wrong with it.
Result<AnnotatedInstance> InstanceFromJson(const nlohmann::json& json);

/// What is set, by the keys of an instance; "new_id" renames it.
nlohmann::json ChangeToJson(const InstanceChange& change);
/// Of an edit's JSON: "edit" and "id" are not part of the change. Errors: kInvalidInput, also for
/// an unknown key.
Result<InstanceChange> ChangeFromJson(const nlohmann::json& json);

}  // namespace plumbline
