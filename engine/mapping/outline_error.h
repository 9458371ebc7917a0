// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>

#include "engine/mapping/judging.h"

namespace plumbline {

/// By how much the mean of a posterior moves for every pixel (at a focal length of 500) by which
/// the edges of an object lie outside of its model's outline, all around and in all its views: the
/// line that an image shows of a bezel, a rim or a shadow is not the outline, and no view
/// contradicts another. To first order that is the covariance of the pose with the derivative of
/// the log posterior by the offset (Gustafson and Wasserman, Annals of Statistics 23, 1995;
/// Giordano, Broderick and Jordan, JMLR 19, 2018).
/// @param hypotheses  Drawn from the posterior of these views, equally weighted, around one pose.
/// @param from        That pose.
/// @return Of the centre in world [m] and the azimuth [rad], per pixel; 0 for a round model's
/// azimuth.
Eigen::Vector4d OutlineSensitivity(const HypothesisScorer& scorer, const MapFrame& map,
                                   std::vector<JudgingView> views,
                                   std::span<const PoseHypothesis> hypotheses,
                                   const PoseHypothesis& from, const MapperOptions& options,
                                   double sharpness);

}  // namespace plumbline
