// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace plumbline {

/// [v]x with [v]x w = v x w.
Eigen::Matrix3d Hat(const Eigen::Vector3d& v);

/// The rotation by |turn| about turn, and back; the angle of the logarithm is in [0, pi].
Eigen::Matrix3d RotationExp(const Eigen::Vector3d& turn);
Eigen::Vector3d RotationLog(const Eigen::Matrix3d& rotation);

/// J with Exp(turn + d) = Exp(J d) Exp(turn) to first order; also the integral over s in [0, 1] of
/// Exp(s turn).
Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& turn);
/// The integral over s in [0, 1] of (1 - s) Exp(s turn): what a turning acceleration adds to the
/// position. At turn = 0 half the identity.
Eigen::Matrix3d SecondIntegral(const Eigen::Vector3d& turn);

/// The nearest rotation of a matrix that has strayed from being one by rounding.
Eigen::Matrix3d Orthonormal(const Eigen::Matrix3d& rotation);

}  // namespace plumbline
