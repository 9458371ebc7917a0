// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/mapping/crop_belief.h"
#include "engine/mapping/existence.h"
#include "engine/mapping/likelihood_sharpness.h"
#include "engine/mapping/map_report.h"
#include "engine/mapping/motion_test.h"
#include "engine/mapping/paper_belief.h"
#include "engine/mapping/particle_set.h"

namespace plumbline {

/// A key frame that an object remembers as a view of it.
struct ObjectView {
  int frame = 0;
  double weight = 1;  ///< How many views it stands for.
};

/// The mapper's belief about one object.
struct MapObject : ObjectBelief {
  std::vector<Particle> particles;
  std::vector<ObjectView> views;
  std::vector<float> memory;  ///< Of each particle: the sum over `views`, see judging.h.
  PoseUncertainty reference_uncertainty;                   ///< Of `world_from_reference_cam`.
  Eigen::Matrix3d shared_error = Eigen::Matrix3d::Zero();  ///< Of its place, see SharedError.
  /// Of place and azimuth, see OutlineCovariance.
  Eigen::Matrix4d outline_covariance = Eigen::Matrix4d::Zero();
  /// Once it is confirmed: of its most likely shape, which comes first, and of others in its place,
  /// see CompareShapes.
  std::vector<LabelProbability> shapes_in_place;
  PoseId reference_pose;       ///< Names it,
  int reference_epoch = 0;     ///< and how often it has been corrected.
  double present_weight = 0;   ///< How much of a view the last frame was, beside `views`.
  LikelihoodSharpness slopes;  ///< Of its views since it was confirmed,
  double sharpness = 1;        ///< and how sharply they are taken.
  double passing = 0;          ///< While tentative, see TentativeEvidence.
  double remembered_evidence = 0, remembered_boxes = 0;  ///< The same.
  double hidden = 0;   ///< Probability that something unmapped hides it, if it is there.
  double shown = 0;    ///< Independent looks in which enough of it showed, see confirm_shown;
                       ///< below 0 while it is lost.
  double seen_s = 0;   ///< Time in which it was updated.
  ObjectId rival;      ///< The object that it competes with for one place, if any,
  double rivalry = 0;  ///< and for how many independent looks it has.
  std::vector<PoseHypothesis> joined;  ///< Of an object merged into this one, for the next search.
  double last_search_s = 0;            ///< Of `seen_s`, at the last search for other poses.
  std::optional<Detection> last_proposal;  ///< The last proposal it explained while tentative, and
                                           ///< where that was seen from.
  Eigen::Isometry3d world_from_proposal_cam = Eigen::Isometry3d::Identity();
  MotionTest motion;  ///< Of a category that moves by itself.
  CropBelief crops;   ///< Since it was confirmed.
  PaperTrack paper;   ///< Of filter = paper.

  const PoseMode& mean() const { return modes.front(); }
  TentativeEvidence evidence() const {
    return {passing, remembered_evidence, remembered_boxes, shown >= 1};
  }
  double remembered() const;  ///< Sum of the weights of `views`.
  /// Goes where its reference view has gone. What it has been judged by may be elsewhere relative
  /// to it now: the next search judges it anew.
  void MoveTo(const PoseEstimate& reference, const MapFrame& map);
  /// Works out modes, covariance, label and pose from the particles; the covariance has the errors
  /// that views share besides, and of another shape is told what `shapes_in_place` has where that
  /// is more than the particles have.
  void Summarize(const MapFrame& map);
};

ObjectReport ToReport(const MapObject& object);
/// Labels of a report are those of its run; of what it keeps besides they are checked here. Errors:
/// kCorrupt.
Result<MapObject> FromReport(const ObjectReport& report, const ModelDatabase& models);

}  // namespace plumbline
