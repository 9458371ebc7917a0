// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/random.h"
#include "engine/geometry/floor_level.h"
#include "engine/geometry/gravity.h"
#include "engine/mapping/hypothesis_scorer.h"
#include "engine/mapping/map_report.h"
#include "engine/mapping/mapper_options.h"
#include "engine/mapping/support_surface.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// How much larger than in a room lengths are that belong to a shape: 1, but for what moves by
/// itself (MovesByItself), the kind of thing that streets are filmed for, and whose horizontal
/// diagonal is longer than `room_thing_m`; growing with that from there on. Such things are called
/// large.
double LengthScale(std::string_view category, const Eigen::AlignedBox3f& bounds,
                   double room_thing_m);

/// What poses of a map's objects refer to: gravity, the floor if one is known, the shapes.
struct MapFrame {
  UprightFrame upright;
  std::optional<Eigen::Vector4d> floor_in_world;  ///< (a, b, c, d), (a, b, c) = up
  std::shared_ptr<const ModelDatabase> database;
  std::vector<SupportSurface> supports = {};  ///< Of mapped objects that stand on the floor.
  double floor_std_m = 0;                     ///< Of the floor's height; 0: given.
  std::vector<Eigen::Vector3f> points_in_world = {};  ///< Of surfaces, whatever they belong to.
  std::vector<FloorLevel> levels = {};                ///< Beside the floor, where one is known.
  double room_thing_m = MapperOptions().room_thing_m;
  std::vector<Eigen::AlignedBox2d> feet = {};  ///< FootOf each model of the database.

  /// plumbline::LengthScale of a shape.
  double LengthScale(ModelId label) const;
  /// To what the place of a thing has to be known to be on the map [m]: to confirm_position_std_m
  /// (times LengthScale), and to half of its largest side: a mug that may be anywhere within 10 cm
  /// may be any mug.
  double LeastKnown(ModelId label, const MapperOptions& options) const;

  /// How far the base of what stands on the floor may be from it: both are uncertain.
  double BaseStd(const MapperOptions& options) const {
    return std::hypot(options.floor_std_m, floor_std_m);
  }

  /// Height of the base of a hypothesis above the floor [m]; requires a floor.
  double BaseHeight(const PoseHypothesis& hypothesis) const;
  /// A height that something may stand at, above the floor.
  struct Standing {
    double height_m = 0, std_m = 0;
  };
  /// What there is to stand on over or under a point, each as likely as the others: the levels
  /// whose outlines hold it or, without any, the floor and the levels that have no outline.
  std::vector<Standing> StandingsAt(const Eigen::Vector3d& point_in_world) const;
  /// The one of these that is nearest to the base of a hypothesis; requires a floor.
  Standing StandingOf(const PoseHypothesis& hypothesis) const;
  /// Whether the floor prior speaks of this shape.
  bool StandsOnFloor(ModelId label) const;
  /// Middle of the bottom of a hypothesis, in the axes of the upright frame.
  Eigen::Vector3d BaseInUpright(const PoseHypothesis& hypothesis) const;
  StandingThing StandingThingOf(const PoseHypothesis& hypothesis) const;
  Eigen::Isometry3d WorldFromObject(const PoseHypothesis& hypothesis) const;
};

PoseHypothesis ToHypothesis(const Particle& particle,
                            const Eigen::Isometry3d& world_from_reference_cam);
/// Keeps label, pose and scale only; a centre behind the reference camera is moved to 5 cm before
/// it.
Particle ToParticle(const PoseHypothesis& hypothesis,
                    const Eigen::Isometry3d& world_from_reference_cam);

/// Difference of azimuths modulo the model's symmetry, in (-pi, pi]; 0 for a continuous symmetry.
double AzimuthDifference(const CadModel& model, double azimuth_rad, double from_rad);

/// Gaussian noise on the four parameters and label jumps. With the floor prior the height of the
/// base follows an Ornstein-Uhlenbeck process whose stationary distribution is the prior, so that
/// it neither drifts nor sharpens with time. `key` has no particle yet.
void Diffuse(std::vector<Particle>& particles, const Eigen::Isometry3d& world_from_reference_cam,
             const MapFrame& map, double dt_s, const MapperOptions& options, RandomKey key);

/// Subtracts the log of the sum of exponentials, so that the weights sum to 1. Returns that log;
/// all weights -inf or NaN become uniform.
double NormalizeLogWeights(std::vector<Particle>& particles);
double EffectiveSampleSize(std::span<const Particle> particles);
/// `count` equally weighted particles; each keeps its ancestor's index.
std::vector<Particle> SystematicResample(std::span<const Particle> particles, int count,
                                         RandomKey key);

/// Clearly separate modes by falling weight: particles of one label within 20 cm (times
/// LengthScale) and 40 degrees of their mean; modes below 5 % are left out (at least one is
/// returned).
std::vector<PoseMode> FindModes(std::span<const Particle> particles,
                                const Eigen::Isometry3d& world_from_reference_cam,
                                const MapFrame& map);
/// Covariance of (centre in world, azimuth) over the particles of a mode.
Eigen::Matrix4d ModeCovariance(const PoseMode& mode, std::span<const Particle> particles,
                               const Eigen::Isometry3d& world_from_reference_cam,
                               const MapFrame& map);
PoseHypothesis ToHypothesis(const PoseMode& mode, const MapFrame& map);
std::vector<LabelProbability> LabelPosterior(std::span<const Particle> particles);

}  // namespace plumbline
