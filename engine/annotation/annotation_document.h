// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "engine/annotation/accepted_finding.h"
#include "engine/annotation/annotated_instance.h"
#include "engine/annotation/crop.h"
#include "engine/annotation/project_state.h"
#include "engine/base/result.h"

namespace plumbline {

/// A point of the scan that was clicked in a frame of the sequence, too.
struct FramePick {
  Eigen::Vector3d in_scan{0, 0, 0};
  int frame = 0;
  Eigen::Vector2d pixel{0, 0};
};

/// What an annotation project says. All poses are in the frame of the scan's file, whatever is
/// found out about gravity later: the original frame is never lost.
struct AnnotationDocument {
  std::string scan;      ///< Path relative to the project file; "" without one.
  std::string models;    ///< Folder of the model database, likewise.
  std::string sequence;  ///< Likewise.
  Eigen::Vector3d gravity_in_scan{0, 0, -1};     ///< Unit vector, down.
  std::optional<Eigen::Vector4d> floor_in_scan;  ///< (a, b, c) = up, ax + by + cz + d = 0.
  /// Where the sequence's world is in the scan; nothing where both share a frame.
  std::optional<Eigen::Isometry3d> scan_from_world;
  std::vector<AnnotatedInstance> instances;
  std::vector<Crop> crops;            ///< What was cut out of the scan.
  std::vector<FramePick> pairs;       ///< That the sequence is registered by.
  std::optional<ProjectState> state;  ///< Nothing: nobody said how far it is.
  /// What was found and is all right; also of objects that have been moved or removed since.
  std::vector<AcceptedFinding> accepted;

  const AnnotatedInstance* Find(const std::string& id) const;
  /// <model>_<N> for the least N that no instance has.
  std::string FreeId(const std::string& model) const;
  const Crop* FindCrop(const std::string& id) const;
  /// Crops that are no model but a part of the scan, as VISMA keeps them.
  int NumFragments() const;
  /// Where nobody said it: new, or in work once there is something in it.
  WorkStage Stage() const;
  /// The scan turned z-up with the floor (if known) at z = 0.
  Eigen::Isometry3d LevelFromScan() const;
};

/// {"in_scan": [x, y, z], "frame", "pixel": [u, v]}
nlohmann::json PairToJson(const FramePick& pair);
/// Errors: kInvalidInput, what is wrong with it.
Result<FramePick> PairFromJson(const nlohmann::json& json);

nlohmann::json DocumentToJson(const AnnotationDocument& document);
/// Unknown keys are ignored. Errors: kInvalidInput, what is wrong and where.
Result<AnnotationDocument> DocumentFromJson(const nlohmann::json& json);

}  // namespace plumbline
