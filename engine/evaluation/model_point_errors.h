// SPDX-License-Identifier: Apache-2.0
#pragma once

// Errors of one pose over the points of a model, as the BOP benchmark defines them (bop_toolkit,
// pose_error.py). Formulas: docs/algorithms/evaluation.md.

#include <span>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/models/model_database.h"
#include "engine/sensor/camera.h"

namespace plumbline {

/// Vertices in `object`. Both poses below may scale them (uniformly, about the origin).
using ModelPoints = std::vector<Eigen::Vector3d>;
ModelPoints PointsOf(const TriangleMesh& mesh);

/// The turns in which a model looks the same, the identity first; of a continuous symmetry 315, so
/// that no point moves further from one to the next than 1 % of the model's diameter.
std::vector<Eigen::Isometry3d> SymmetricTurns(const Symmetry& symmetry);

/// ADD: mean distance between the same points [m].
double AddError(const Eigen::Affine3d& estimate, const Eigen::Affine3d& truth,
                const ModelPoints& points);
/// ADD-S (ADI): mean over the true points of the distance to the nearest estimated one [m].
double AddSError(const Eigen::Affine3d& estimate, const Eigen::Affine3d& truth,
                 const ModelPoints& points);
/// MSSD: largest distance between the same points, for the best of the turns [m].
double MssdError(const Eigen::Affine3d& estimate, const Eigen::Affine3d& truth,
                 const ModelPoints& points, std::span<const Eigen::Isometry3d> turns);
/// MSPD: the same between their projections [px]. Infinite where a point is not before the camera.
/// @param estimate, truth  cam_from_object.
double MspdError(const Eigen::Affine3d& estimate, const Eigen::Affine3d& truth,
                 const PinholeCamera& camera, const ModelPoints& points,
                 std::span<const Eigen::Isometry3d> turns);

/// Length of the ray of each pixel [m], CV_32F, of Z depths; 0 stays 0.
cv::Mat RayLengths(const cv::Mat& depth, const PinholeCamera& camera);

/// The model in both poses, alone, and what was measured there: ray lengths [m], 0 for nothing.
struct VsdImages {
  cv::Mat estimate, truth, scene;
};
inline constexpr double kVsdTolerance_m = 0.015;  ///< delta of BOP.

/// VSD for each misalignment tolerance tau, given as a share of the diameter. 1 where neither
/// shows.
std::vector<double> VsdErrors(const VsdImages& images, double diameter_m,
                              std::span<const double> taus);
/// Pixels of the true object that nothing measured hides.
int VisiblePixels(const cv::Mat& truth, const cv::Mat& scene);

}  // namespace plumbline
