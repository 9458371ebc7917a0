// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small symmetric systems. What they need of Eigen is compiled once: a source that instantiates a
// decomposition or a product of matrices of any size takes the compiler many seconds longer.

#include <utility>

#include <Eigen/Core>

namespace plumbline {

struct SymmetricEigen {
  Eigen::VectorXd values;   ///< Rising.
  Eigen::MatrixXd vectors;  ///< Columns, in the order of the values.
};

/// Eigenvalues and eigenvectors of a symmetric matrix.
SymmetricEigen EigenOf(const Eigen::MatrixXd& symmetric);

/// The solution of `symmetric` * x = `right`; the matrix need not be definite.
Eigen::VectorXd SolveSymmetric(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& right);

Eigen::MatrixXd InverseOfSymmetric(const Eigen::MatrixXd& symmetric);

/// The moves that are free: the combinations of some directions. Quadratic forms and gradients over
/// all moves are restricted to it; steps and covariances of the free moves are expanded to all.
class Subspace {
 public:
  /// @param directions  One column for each free move.
  explicit Subspace(Eigen::MatrixXd directions) : directions_(std::move(directions)) {}

  int size() const { return static_cast<int>(directions_.cols()); }
  const Eigen::MatrixXd& directions() const { return directions_; }           ///< Z
  Eigen::MatrixXd RestrictForm(const Eigen::MatrixXd& form) const;            ///< Z' form Z
  Eigen::VectorXd RestrictGradient(const Eigen::VectorXd& gradient) const;    ///< Z' gradient
  Eigen::VectorXd ExpandStep(const Eigen::VectorXd& step) const;              ///< Z step
  Eigen::MatrixXd ExpandCovariance(const Eigen::MatrixXd& covariance) const;  ///< Z covariance Z'

 private:
  Eigen::MatrixXd directions_;  ///< Z
};

}  // namespace plumbline
