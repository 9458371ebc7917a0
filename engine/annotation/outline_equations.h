// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/annotation/annotation_images.h"
#include "engine/annotation/edge_search.h"
#include "engine/geometry/symmetric_matrix.h"
#include "engine/registration/constrained_fit.h"

// What the images say of how a posed model should move: the measurements of RefineByImages
// (docs/algorithms/image_refinement.md).

namespace plumbline {

/// Shift of the model's middle in the scan [m], then the turn about up [rad], from the start.
using PoseMove = Eigen::Vector4d;
using MoveInformation = Eigen::Matrix4d;

/// Octants of the model.
constexpr int kModelParts = 8;

/// A point of the outline in one image.
struct OutlineObservation {
  Eigen::Vector3d in_object;
  Eigen::Vector2d normal;
  double length_px;  ///< Creases count less.
  int part;          ///< Octant of the model.
  bool contour;      ///< The normal points out of the object.
};
using OutlineObservations = std::vector<std::vector<OutlineObservation>>;  ///< By image.

/// Poses that a move from the start reaches. The turn stays one angle, so the tilt stays exact.
class UprightMotion {
 public:
  UprightMotion(const Eigen::Isometry3d& start, const Eigen::Vector3d& up,
                const Eigen::Vector3d& middle)
      : start_(start), up_(up), middle_(middle), middle_in_scan_(start * middle) {}

  Eigen::Isometry3d At(const PoseMove& move) const;
  Eigen::Vector3d MiddleAt(const PoseMove& move) const { return middle_in_scan_ + move.head<3>(); }
  const Eigen::Vector3d& up() const { return up_; }
  const Eigen::Vector3d& middle() const { return middle_; }

  Subspace Free(FreeMotion motion) const;

 private:
  Eigen::Isometry3d start_;
  Eigen::Vector3d up_, middle_, middle_in_scan_;
};

/// Of one image, or all: the normal equations of the distances to the edges.
struct OutlineEquations {
  MoveInformation information = MoveInformation::Zero();  ///< Sum of weight * J^T J.
  PoseMove gradient = PoseMove::Zero();                   ///< Sum of weight * J^T * distance.
  PoseMove outward = PoseMove::Zero();  ///< The gradient if all contours lay a pixel further out.
  double weight = 0, squares = 0;
  int samples = 0;

  OutlineEquations& operator+=(const OutlineEquations& other) {
    information += other.information;
    gradient += other.gradient;
    outward += other.outward;
    weight += other.weight;
    squares += other.squares;
    samples += other.samples;
    return *this;
  }
};
/// Of one image.
using EquationsByPart = std::array<OutlineEquations, kModelParts>;

/// Pixel of a point in the scan; nothing behind the camera.
std::optional<Eigen::Vector2d> ProjectInto(const AnnotationImage& image,
                                           const PinholeCamera& camera,
                                           const Eigen::Vector3d& in_scan);

/// The equations of each image at a move: each observation against the edge that counts most along
/// its normal. On all cores; the same for the same input.
std::vector<EquationsByPart> CollectEquations(const AnnotationImages& images,
                                              const UprightMotion& motion,
                                              const OutlineObservations& observations,
                                              const PoseMove& move,
                                              const EdgeAgreementOptions& edges);

OutlineEquations Sum(const std::vector<EquationsByPart>& equations);

/// Covariance of the free parameters by leaving out one group of measurements at a time.
/// @param scale        Turns sums over pixels of line into information.
/// @param information  Of all, the prior included.
Eigen::MatrixXd Jackknife(const std::vector<OutlineEquations>& groups, double scale,
                          const Eigen::MatrixXd& information, const Subspace& free);

}  // namespace plumbline
