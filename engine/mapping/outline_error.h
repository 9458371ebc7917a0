// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>

#include "engine/mapping/judging.h"

namespace plumbline {

/// By how much the mean of a posterior moves for every pixel (at a focal length of 500) by which
/// the edges of an object lie outside of its model's outline where that faces right, down, left and
/// up, in all its views: the line that an image shows of a bezel, a rim or a shadow is not the
/// outline, and no view contradicts another. To first order that is the covariance of the pose with
/// the derivative of the log posterior by the offset (Gustafson and Wasserman, Annals of Statistics
/// 23, 1995; Giordano, Broderick and Jordan, JMLR 19, 2018).
/// @param hypotheses  Drawn from the posterior of these views, equally weighted, around one pose.
/// @param from        That pose.
/// @return A column for each side: of the centre in world [m] and the azimuth [rad], per pixel; 0
/// for a round model's azimuth.
Eigen::Matrix4d OutlineSensitivity(const HypothesisScorer& scorer, const MapFrame& map,
                                   std::vector<JudgingView> views,
                                   std::span<const PoseHypothesis> hypotheses,
                                   const PoseHypothesis& from, const MapperOptions& options,
                                   double sharpness);

/// Covariance of the pose, as offsets are alike all around with the first deviation and each side
/// has its own with the second.
Eigen::Matrix4d OutlineCovariance(const Eigen::Matrix4d& sensitivity, double all_around_std_px,
                                  double side_std_px);

}  // namespace plumbline
