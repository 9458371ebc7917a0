// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/pose_graph.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include "engine/base/check.h"

namespace plumbline {
namespace {

using Matrix48 = Eigen::Matrix<double, 4, 8>;
using Matrix84 = Eigen::Matrix<double, 8, 4>;

/// An edge's error, and how it moves with (x, y, z, yaw) of `from` and of `to`.
struct LinearEdge {
  Eigen::Vector4d error;
  Matrix48 by_poses;
};

Eigen::Matrix3d AboutUp(double yaw_rad) {
  return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

LinearEdge Linearise(const GraphEdge& edge, const GraphPose& from, const GraphPose& to) {
  const Eigen::Matrix3d back = AboutUp(-from.yaw_rad);
  const Eigen::Vector3d step = back * (to.position_in_world - from.position_in_world);
  LinearEdge linear;
  linear.error << step - edge.step,
      std::remainder(to.yaw_rad - from.yaw_rad - edge.yaw_rad, 2 * M_PI);
  linear.by_poses.setZero();
  linear.by_poses.block<3, 3>(0, 0) = -back;
  linear.by_poses.block<3, 1>(0, 3) = step.cross(Eigen::Vector3d::UnitZ());
  linear.by_poses.block<3, 3>(0, 4) = back;
  linear.by_poses(3, 3) = -1;
  linear.by_poses(3, 7) = 1;
  return linear;
}

/// With W' W = covariance^-1.
Eigen::Matrix4d WhiteningOf(const Eigen::Matrix4d& covariance) {
  const Eigen::LLT<Eigen::Matrix4d> factor(covariance);
  PLB_CHECK(factor.info() == Eigen::Success) << "the covariance of an edge is not positive";
  return factor.matrixL().solve(Eigen::Matrix4d::Identity());
}

/// The error of an edge for Ceres, by blocks (yaw, position) of both poses.
class EdgeCost : public ceres::SizedCostFunction<4, 1, 3, 1, 3> {
 public:
  explicit EdgeCost(const GraphEdge& edge) : edge_(edge), whiten_(WhiteningOf(edge.covariance)) {}

  bool Evaluate(double const* const* poses, double* residual, double** jacobians) const override {
    const GraphPose from{*poses[0], Eigen::Map<const Eigen::Vector3d>(poses[1])};
    const GraphPose to{*poses[2], Eigen::Map<const Eigen::Vector3d>(poses[3])};
    const LinearEdge linear = Linearise(edge_, from, to);
    const Eigen::Vector4d error = whiten_ * linear.error;
    std::copy(error.begin(), error.end(), residual);
    if (jacobians == nullptr) return true;
    const Matrix48 white = whiten_ * linear.by_poses;
    for (int end = 0; end < 2; ++end) {
      double *by_yaw = jacobians[2 * end], *by_position = jacobians[2 * end + 1];
      for (int row = 0; row < 4; ++row) {  // as Ceres stores them: row by row
        if (by_yaw != nullptr) by_yaw[row] = white(row, 4 * end + 3);
        for (int axis = 0; axis < 3 && by_position != nullptr; ++axis)
          by_position[3 * row + axis] = white(row, 4 * end + axis);
      }
    }
    return true;
  }

 private:
  GraphEdge edge_;
  Eigen::Matrix4d whiten_;
};

/// doubt x / (doubt + x) of a squared error x.
class SwitchLoss : public ceres::LossFunction {
 public:
  explicit SwitchLoss(double doubt) : doubt_(doubt) {}
  void Evaluate(double x, double out[3]) const override {
    const double trust = doubt_ / (doubt_ + x);
    out[0] = trust * x;
    out[1] = trust * trust;
    out[2] = -2 * trust * trust / (doubt_ + x);
  }

 private:
  double doubt_;
};

void Solve(double doubt, std::vector<GraphPose>& poses, std::span<const GraphEdge> edges) {
  ceres::Problem problem;
  for (const GraphEdge& edge : edges) {
    GraphPose &from = poses[static_cast<std::size_t>(edge.from)],
              &to = poses[static_cast<std::size_t>(edge.to)];
    problem.AddResidualBlock(new EdgeCost(edge), edge.doubtful ? new SwitchLoss(doubt) : nullptr,
                             &from.yaw_rad, from.position_in_world.data(), &to.yaw_rad,
                             to.position_in_world.data());
  }
  for (double* fixed : {&poses.front().yaw_rad, poses.front().position_in_world.data()}) {
    if (problem.HasParameterBlock(fixed)) problem.SetParameterBlockConstant(fixed);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.num_threads = 1;
  options.max_num_iterations = 30;
  options.function_tolerance = 1e-9;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

/// The information about all poses but the first, with doubtful edges at their present weight.
Eigen::SparseMatrix<double> Information(const PoseGraph& graph) {
  const auto size = static_cast<Eigen::Index>(4 * (graph.poses().size() - 1));
  std::vector<Eigen::Triplet<double>> entries;
  for (const GraphEdge& edge : graph.edges()) {
    const LinearEdge linear = Linearise(edge, graph.poses()[static_cast<std::size_t>(edge.from)],
                                        graph.poses()[static_cast<std::size_t>(edge.to)]);
    const Matrix48 white = graph.TrustIn(edge) * WhiteningOf(edge.covariance) * linear.by_poses;
    const Eigen::Matrix<double, 8, 8> information = white.transpose() * white;
    const int begin[] = {4 * (edge.from - 1), 4 * (edge.to - 1)};
    for (int row = 0; row < 8; ++row) {
      for (int column = 0; column < 8; ++column) {
        const int r = begin[row / 4] + row % 4, c = begin[column / 4] + column % 4;
        if (r >= 0 && c >= 0) entries.emplace_back(r, c, information(row, column));
      }
    }
  }
  Eigen::SparseMatrix<double> information(size, size);
  information.setFromTriplets(entries.begin(), entries.end());
  return information;
}

/// Covariance of (x, y, z, yaw) of all poses but the first.
class Covariances {
 public:
  explicit Covariances(const PoseGraph& graph) : factor_(Information(graph)) {
    PLB_CHECK(factor_.info() == Eigen::Success) << "a pose of the graph is tied to no other";
  }
  /// The columns of the covariance that belong to a pose; none for the first, which is certain.
  Eigen::MatrixXd ColumnsOf(int pose) const {
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(factor_.rows(), 4);
    if (pose == 0) return unit;
    unit.middleRows<4>(4 * (pose - 1)).setIdentity();
    return factor_.solve(unit);
  }

  /// Multiplications that a factor like this one takes, about.
  double Work() const {
    const Eigen::SparseMatrix<double>& l = factor_.matrixL().nestedExpression();
    double work = 0;
    for (Eigen::Index column = 0; column < l.outerSize(); ++column) {
      const double below = l.outerIndexPtr()[column + 1] - l.outerIndexPtr()[column];
      work += below * below;
    }
    return work;
  }

  /// Covariance of each pose but the first, without those between poses: entries of the inverse
  /// where the factor has any, column by column from the last one (Takahashi, Fagan and Chin, 1973;
  /// Erisman and Tinney, CACM 1975). What it costs grows with the factor, not with its square.
  std::vector<Eigen::Matrix4d> OfEachPose() const {
    const Inverse inverse(factor_);
    const auto& order = factor_.permutationP().indices();
    std::vector<Eigen::Matrix4d> blocks(static_cast<std::size_t>(factor_.rows() / 4));
    for (std::size_t pose = 0; pose < blocks.size(); ++pose) {
      for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column)
          blocks[pose](row, column) =
              inverse.At(order[static_cast<Eigen::Index>(4 * pose) + row],
                         order[static_cast<Eigen::Index>(4 * pose) + column]);
      }
    }
    return blocks;
  }

 private:
  using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;

  /// Of the permuted information L D L', where L has an entry, and on the diagonal.
  class Inverse {
   public:
    explicit Inverse(const Factor& factor)
        : lower_(factor.matrixL().nestedExpression()), diagonal_(factor.rows()) {
      const Eigen::SparseMatrix<double>& l = factor.matrixL().nestedExpression();
      const auto& d = factor.vectorD();
      for (Eigen::Index column = factor.rows() - 1; column >= 0; --column) {
        const int begin = l.outerIndexPtr()[column], end = l.outerIndexPtr()[column + 1];
        double own = 1 / d[column];
        for (int row = begin; row < end; ++row) {
          double sum = 0;
          for (int k = begin; k < end; ++k)
            sum += l.valuePtr()[k] * At(l.innerIndexPtr()[row], l.innerIndexPtr()[k]);
          lower_.valuePtr()[row] = -sum;
          own += l.valuePtr()[row] * sum;
        }
        diagonal_[column] = own;
      }
    }
    /// In the order of the factor, where it has an entry.
    double At(Eigen::Index row, Eigen::Index column) const {
      if (row == column) return diagonal_[row];
      if (row < column) std::swap(row, column);
      const int* begin = lower_.innerIndexPtr() + lower_.outerIndexPtr()[column];
      const int* end = lower_.innerIndexPtr() + lower_.outerIndexPtr()[column + 1];
      const int* found = std::lower_bound(begin, end, static_cast<int>(row));
      PLB_CHECK(found != end && *found == row);
      return lower_.valuePtr()[found - lower_.innerIndexPtr()];
    }

   private:
    Eigen::SparseMatrix<double> lower_;
    Eigen::VectorXd diagonal_;
  };

  Factor factor_;
};

/// One edge for two that meet: what they say of each other's far ends.
GraphEdge Joined(const GraphEdge& first, const GraphEdge& second) {
  const Eigen::Matrix3d turn = AboutUp(first.yaw_rad);
  GraphEdge joined = first;
  joined.to = second.to;
  joined.step = first.step + turn * second.step;
  joined.yaw_rad = first.yaw_rad + second.yaw_rad;
  Eigen::Matrix4d by_first = Eigen::Matrix4d::Identity(), by_second = Eigen::Matrix4d::Identity();
  by_first.topRightCorner<3, 1>() = Eigen::Vector3d::UnitZ().cross(turn * second.step);
  by_second.topLeftCorner<3, 3>() = turn;
  joined.covariance = by_first * first.covariance * by_first.transpose() +
                      by_second * second.covariance * by_second.transpose();
  return joined;
}

Eigen::Matrix4d RowsOfPose(const Eigen::MatrixXd& columns, int pose) {
  if (pose == 0) return Eigen::Matrix4d::Zero();
  return columns.middleRows<4>(4 * (pose - 1));
}

}  // namespace

void PoseGraph::AddEdge(const GraphEdge& edge) {
  const int count = static_cast<int>(poses_.size());
  PLB_CHECK(edge.from >= 0 && edge.to >= 0 && edge.from < count && edge.to < count);
  PLB_CHECK(edge.from != edge.to);
  edges_.push_back(edge);
}

std::vector<int> PoseGraph::TakeOut(const std::vector<bool>& unwanted) {
  // Of each pose the certain edge that leads there and the one that leads on.
  constexpr int kNone = -1, kSeveral = -2;
  std::vector<int> before(poses_.size(), kNone), after(poses_.size(), kNone);
  const auto note = [](int edge, int& noted) { noted = noted == kNone ? edge : kSeveral; };
  for (int i = 0; i < static_cast<int>(edges_.size()); ++i) {
    const GraphEdge& edge = edges_[static_cast<std::size_t>(i)];
    const auto from = static_cast<std::size_t>(edge.from), to = static_cast<std::size_t>(edge.to);
    note(i, after[from]);
    note(i, before[to]);
    if (!edge.doubtful) continue;
    after[from] = before[from] = after[to] = before[to] = kSeveral;
  }
  std::vector<bool> joined(edges_.size(), false);
  std::vector<int> number(poses_.size());
  int count = 0;
  for (std::size_t pose = 0; pose < poses_.size(); ++pose) {
    const bool goes = unwanted[pose] && before[pose] >= 0 && after[pose] >= 0;
    number[pose] = goes ? -1 : count++;
    if (!goes) continue;
    const auto last = static_cast<std::size_t>(after[pose]);
    GraphEdge& edge = edges_[static_cast<std::size_t>(before[pose])];
    edge = Joined(edge, edges_[last]);
    joined[last] = true;
    int& of_next = before[static_cast<std::size_t>(edge.to)];
    if (of_next >= 0) of_next = before[pose];
  }
  std::vector<GraphPose> poses;
  for (std::size_t pose = 0; pose < poses_.size(); ++pose) {
    if (number[pose] >= 0) poses.push_back(poses_[pose]);
  }
  std::vector<GraphEdge> edges;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (joined[i]) continue;
    GraphEdge& edge = edges.emplace_back(edges_[i]);
    edge.from = number[static_cast<std::size_t>(edge.from)];
    edge.to = number[static_cast<std::size_t>(edge.to)];
  }
  poses_ = std::move(poses);
  edges_ = std::move(edges);
  return number;
}

void PoseGraph::RemoveLastEdge() { edges_.pop_back(); }

void PoseGraph::Optimise() {
  if (edges_.empty()) return;
  const bool doubts =
      std::any_of(edges_.begin(), edges_.end(), [](const GraphEdge& e) { return e.doubtful; });
  for (const double ease : {1000.0, 30.0, 1.0}) {
    if (doubts || ease == 1) Solve(ease * doubt_, poses_, edges_);
  }
}

Eigen::Vector4d PoseGraph::ErrorOf(const GraphEdge& edge) const {
  return Linearise(edge, poses_[static_cast<std::size_t>(edge.from)],
                   poses_[static_cast<std::size_t>(edge.to)])
      .error;
}

double PoseGraph::TrustIn(const GraphEdge& edge) const {
  if (!edge.doubtful) return 1;
  return doubt_ / (doubt_ + (WhiteningOf(edge.covariance) * ErrorOf(edge)).squaredNorm());
}

Eigen::Matrix4d PoseGraph::RelativeCovariance(int from, int to) const {
  PLB_CHECK(from != to);
  const Covariances covariances(*this);
  const Eigen::MatrixXd of_from = covariances.ColumnsOf(from), of_to = covariances.ColumnsOf(to);
  Eigen::Matrix<double, 8, 8> joint;
  joint << RowsOfPose(of_from, from), RowsOfPose(of_to, from), RowsOfPose(of_from, to),
      RowsOfPose(of_to, to);
  const LinearEdge linear = Linearise({from, to}, poses_[static_cast<std::size_t>(from)],
                                      poses_[static_cast<std::size_t>(to)]);
  const Eigen::Matrix4d covariance = linear.by_poses * joint * linear.by_poses.transpose();
  return (covariance + covariance.transpose()) / 2;
}

std::vector<Eigen::Matrix4d> PoseGraph::Marginals() const {
  std::vector<Eigen::Matrix4d> marginals(poses_.size(), Eigen::Matrix4d::Zero());
  if (poses_.size() < 2) return marginals;
  const std::vector<Eigen::Matrix4d> others = Covariances(*this).OfEachPose();
  std::copy(others.begin(), others.end(), marginals.begin() + 1);
  return marginals;
}

double PoseGraph::Work() const { return poses_.size() < 2 ? 0 : Covariances(*this).Work(); }

}  // namespace plumbline
