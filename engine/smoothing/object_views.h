// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/mapping/map_object.h"
#include "engine/mapping/mapper.h"
#include "engine/smoothing/looks.h"

namespace plumbline {

/// Lengths and areas in pixels that options speak of are those of a camera of this focal length.
inline constexpr double kFocalOfLengths_px = 500;
/// Share of a contour that shows in a view worth using.
inline constexpr double kLeastSight = 0.15;

/// How much a contour can say, in [0, 1]: a small or hidden one says less than a long one.
double Telling(const HypothesisScore& score, double depth_m, const MapperOptions& options);

/// What a look shows of an object at its believed pose.
struct ObjectSight {
  int frame = 0;                  ///< Of the look.
  double visible_fraction = 0;    ///< Of its contour, in (0, 1].
  double telling = 0;             ///< How much its contour can say, in (0, 1].
  double steadiness = 1;          ///< Of the look.
  Eigen::Vector3d from{0, 0, 0};  ///< Unit, from the object's centre towards the camera.
  double distance_m = 0;
};

/// An image as hypotheses of one object are scored in it.
/// @param maps  Of those that may hide it.
ScoringView ViewOf(const MapperSetup& setup, const Eigen::Isometry3d& world_from_cam,
                   const OcclusionMaps& maps, ObjectId object, const OrientedTable& table);

/// Where objects stand, to draw them.
std::vector<PlacedModel> MeanStates(std::span<const MapObject> objects, bool confirmed_only);

/// Of each object, the looks that show it, as far as the confirmed ones leave it to be seen.
/// Renders each look once and reads no image.
std::vector<std::vector<ObjectSight>> FindSights(const MapperSetup& setup,
                                                 OcclusionRenderer& renderer,
                                                 std::span<const Look> looks,
                                                 std::span<const MapObject> objects);

/// Indices of at most `count` sights that show much of the object and from as different sides and
/// distances as there are, the best one first; over the whole recording, whenever the object was
/// found.
std::vector<std::size_t> ChooseViews(std::span<const ObjectSight> sights, int count);

}  // namespace plumbline
