// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// A finding that somebody looked at and called all right, with what it was said of: it holds as
/// long as that is so.
struct AcceptedFinding {
  struct Object {
    std::string id, model;
    double scale = 1;
    Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
  };
  std::string kind;             ///< Of AnnotationFinding, as are the next two.
  std::vector<Object> objects;  ///< That it concerns, one or more.
  double amount = 0;
  std::string unit;
  std::string by, note;  ///< Who said so, and why; both may be empty.

  /// Whether it is about the same thing, whatever is said of it. @param ids In any order.
  bool IsAbout(const std::string& finding_kind, const std::vector<std::string>& ids) const;
};

/// By how much an object may move, or the finding grow, for the acceptance to hold.
struct AcceptanceLimits {
  double shift_m = 0.01, turn_deg = 1;
  double growth_m = 0.01, growth_deg = 0.5;
};

nlohmann::json AcceptedToJson(const AcceptedFinding& accepted);
/// Errors: kInvalidInput, what is wrong with it.
Result<AcceptedFinding> AcceptedFromJson(const nlohmann::json& json);

}  // namespace plumbline
