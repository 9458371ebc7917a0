// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/symmetric_matrix.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace plumbline {

SymmetricEigen EigenOf(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd SolveSymmetric(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& right) {
  return symmetric.ldlt().solve(right);
}

Eigen::MatrixXd InverseOfSymmetric(const Eigen::MatrixXd& symmetric) {
  const Eigen::LDLT<Eigen::MatrixXd> solver(symmetric);
  Eigen::MatrixXd inverse(symmetric.rows(), symmetric.cols());
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(symmetric.rows());
  for (Eigen::Index i = 0; i < unit.size(); ++i) {
    unit[i] = 1;
    inverse.col(i) = solver.solve(unit);
    unit[i] = 0;
  }
  return inverse;
}

Eigen::MatrixXd Subspace::RestrictForm(const Eigen::MatrixXd& form) const {
  return directions_.transpose() * form * directions_;
}

Eigen::VectorXd Subspace::RestrictGradient(const Eigen::VectorXd& gradient) const {
  return directions_.transpose() * gradient;
}

Eigen::VectorXd Subspace::ExpandStep(const Eigen::VectorXd& step) const {
  return directions_ * step;
}

Eigen::MatrixXd Subspace::ExpandCovariance(const Eigen::MatrixXd& covariance) const {
  return directions_ * covariance * directions_.transpose();
}

}  // namespace plumbline
