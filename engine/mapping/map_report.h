// SPDX-License-Identifier: Apache-2.0
#pragma once

// What one step of the mapper did, as values. This is what the run file stores, what the window
// draws and what a run resumes from; it includes nothing but base and geometry, so that the
// snapshot may hold it.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/ids.h"
#include "engine/geometry/box.h"
#include "engine/mapping/event_report.h"
#include "engine/sensor/pose_estimate.h"

namespace plumbline {

/// One hypothesis of an object's shape and pose: shape label k, and the centre of its model's
/// bounding box at exp(rho) * [x_c, y_c, 1] in the camera frame of the object's reference time;
/// azimuth about up [rad]; how much larger than the model it is.
struct Particle {
  float x_c = 0, y_c = 0;      ///< Bearing, (X/Z, Y/Z) in the reference camera.
  float rho = 0;               ///< log(Z / 1 m).
  float azimuth = 0;           ///< (-pi, pi]
  float log_weight = 0;        ///< Normalised: the exponentials of an object's particles sum to 1.
  float phi_cnn = 0;           ///< Detector term of the last frame in which the object was updated.
  float phi_edge = 0;          ///< Edge term, likewise.
  std::uint16_t label = 0;     ///< ModelId
  std::uint16_t ancestor = 0;  ///< Index, in the last frame's set, of the particle it comes from.
  float log_scale = 0;         ///< 0 unless scale_std > 0.
};

/// One of several clearly separate places where an object may be.
struct PoseMode {
  ModelId label;
  double weight = 0;  ///< Share of the particles' weight.
  Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
  double position_std_m = 0;
  double azimuth_std_rad = 0;
  double scale = 1;  ///< As of ObjectBelief.
  double scale_std = 0;
};

/// What the mapper believes of one object, and how it fared in the last frame. The mapper works on
/// it, its report contains it.
struct ObjectBelief {
  ObjectId id;
  ObjectState state = ObjectState::kTentative;
  std::string category;
  int reference_frame = 0;
  Eigen::Isometry3d world_from_reference_cam = Eigen::Isometry3d::Identity();
  int first_frame = 0;
  std::optional<int> confirmed_frame;
  int last_frame = 0;  ///< Last frame in which it was updated.

  ModelId label;                                    ///< Most likely shape.
  std::vector<LabelProbability> label_probability;  ///< Falling; sums to 1.
  Eigen::Isometry3d world_from_object =
      Eigen::Isometry3d::Identity();  ///< Mean of the heaviest mode.
  /// point_in_world = world_from_object * (scale * point_in_object): so many times as large as its
  /// model. 1 with a deviation of 0 unless the mapper's scale_std > 0.
  double scale = 1;
  double scale_std = 0;
  Eigen::Matrix4d covariance =
      Eigen::Matrix4d::Zero();  ///< Of (x, y, z of the centre in world [m], azimuth [rad]).
  std::vector<PoseMode> modes;  ///< By falling weight; the first one is the mean above.
  double effective_sample_size = 0;
  double log_evidence = 0;  ///< Log odds that the object exists.

  bool updated = false;  ///< False: hidden, behind the camera or outside; it kept its belief.
  double visible_fraction = 0;      ///< Share of the mean contour that shows.
  float phi_cnn = 0, phi_edge = 0;  ///< Both terms at the mean.
  Box2 whole_box,
      visible_box;  ///< Of the mean in this image [px], clipped to it; empty if it does not show.
};

struct ObjectReport : ObjectBelief {
  std::shared_ptr<const std::vector<Particle>> particles;
  std::string filter_state;  ///< Opaque bytes that only the mapper reads, to resume.
};

enum class ProposalFate : std::uint8_t {
  kExplained,        ///< by `object`
  kSpawned,          ///< gave birth to `object`
  kUnknownCategory,  ///< no model of this category
  kLowScore,
  kImplausible,  ///< no place for a model of the category in this box
};

constexpr std::string_view NameOf(ProposalFate fate) {
  constexpr std::array<std::string_view, 5> kNames = {"explained", "spawned", "unknown_category",
                                                      "low_score", "implausible"};
  return kNames.at(static_cast<std::size_t>(fate));
}

struct ProposalReport {
  Box2 box;
  std::string category;
  float score = 0;
  ProposalFate fate = ProposalFate::kLowScore;
  ObjectId object;
};

/// A settled object that is seen again after the poses have drifted. It has not moved: the camera
/// is elsewhere than its pose says.
struct LandmarkSighting {
  ObjectId object;
  PoseId reference_pose;  ///< Of the image that the object's pose refers to,
  PoseId present_pose;    ///< and of this one.
  /// Of its bounds, as it was known and as the newest views alone have it, each in the world of its
  /// poses [m], [rad].
  Eigen::Vector3d center_in_world{0, 0, 0}, center_in_world_now{0, 0, 0};
  double azimuth_rad = 0, azimuth_now_rad = 0;
  Eigen::Matrix4d covariance =
      Eigen::Matrix4d::Identity();  ///< Of (centre, azimuth), now less then.
};

struct FrameReport {
  int frame = 0;
  std::int64_t stamp_ns = 0;
  std::optional<Eigen::Isometry3d> world_from_cam;
  std::string skipped;  ///< "" or why this frame was not used.
  SkipCause skip_cause = SkipCause::kUnknown;
  std::vector<ProposalReport> proposals;
  std::vector<ObjectReport>
      objects;  ///< By id; a retired object is reported once, in the frame of its retirement.
  std::vector<LifeEvent> events;
  std::vector<StageTiming> timings;
  std::int32_t next_object_id = 1;
  std::string mapper_state;  ///< Opaque bytes that only the mapper reads, to resume.
  /// For whoever corrects poses; run files keep what they were corrected by (kPosesCorrected).
  std::vector<LandmarkSighting> landmarks;
};

}  // namespace plumbline
