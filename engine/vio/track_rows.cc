// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/track_rows.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "engine/base/check.h"

namespace plumbline {
namespace {

/// Turns rows of unit noise, two for each sight, on which a random walk with steps of
/// `creep[i]` in the units of sight i lies, into such of unit noise.
void Whiten(const std::vector<double>& creep, TrackRows& rows) {
  const Eigen::Index count = rows.residual.size() / 2;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(2 * count, 2 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index k = 0; k < count; ++k) {
      const double common = creep[static_cast<std::size_t>(i)] *
                            creep[static_cast<std::size_t>(k)] *
                            static_cast<double>(std::min(i, k));
      covariance(2 * i, 2 * k) += common;
      covariance(2 * i + 1, 2 * k + 1) += common;
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> root(covariance);
  root.matrixL().solveInPlace(rows.by_state);
  root.matrixL().solveInPlace(rows.by_point);
  root.matrixL().solveInPlace(rows.residual);
}

}  // namespace

ColumnLayout::ColumnLayout(const FilterState& state, bool lens)
    : has_lens_(lens), first_clone_column_(kPoseSize + (lens ? kLensSize : 0)) {
  rows_.push_back({kCamRotation, kPoseSize});
  if (lens) rows_.push_back({kLens, kLensSize});
  size_ = first_clone_column_;
  for (const PoseClone& clone : state.clones()) {
    rows_.push_back({clone.row, kPoseSize});
    clones_.push_back(clone.id);
    size_ += kPoseSize;
  }
}

int ColumnLayout::AddPoint(const StatePoint& point) {
  rows_.push_back({point.row, kPointSize});
  size_ += kPointSize;
  return size_ - kPointSize;
}

int ColumnLayout::clone(std::int64_t id) const {
  const auto found = std::lower_bound(clones_.begin(), clones_.end(), id);
  PLB_CHECK(found != clones_.end() && *found == id);
  return first_clone_column_ + kPoseSize * static_cast<int>(found - clones_.begin());
}

Eigen::Matrix<double, 2, kLensSize> SightByLens(const DistortedCamera& camera,
                                                const PixelModel& pixels, const PointView& view,
                                                const PoseClone& clone, double row_px) {
  Eigen::Matrix<double, 2, kLensSize> by_lens;
  by_lens << camera.PixelByIntrinsics(view.point_in_cam),
      view.by_pose * pixels.MotionOfRow(clone, row_px);
  return by_lens;
}

std::optional<TrackRows> RowsOfTrack(const DistortedCamera& camera, const FilterState& state,
                                     const ColumnLayout& layout,
                                     std::span<const Observation> observations,
                                     const std::vector<bool>& used,
                                     const Eigen::Vector3d& point_in_world,
                                     const PixelModel& pixels) {
  const auto count = std::count(used.begin(), used.end(), true);
  TrackRows rows;
  rows.by_state = Eigen::MatrixXd::Zero(2 * count, layout.size());
  rows.by_point.resize(2 * count, 3);
  rows.residual.resize(2 * count);
  std::vector<double> creep;
  int row = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!used[i]) continue;
    const PoseClone* clone = state.FindClone(observations[i].clone);
    PLB_CHECK(clone != nullptr);
    const auto view =
        ViewPoint(camera, state.body_from_cam(),
                  pixels.WorldFromBody(*clone, observations[i].pixel.y()), point_in_world);
    if (!view) return std::nullopt;
    const double noise = pixels.NoiseIn(*clone);
    rows.by_state.block<2, 6>(row, layout.camera()) = view->by_camera / noise;
    if (layout.has_lens()) {
      rows.by_state.block<2, kLensSize>(row, layout.lens()) =
          SightByLens(camera, pixels, *view, *clone, observations[i].pixel.y()) / noise;
    }
    rows.by_state.block<2, 6>(row, layout.clone(clone->id)) = view->by_pose / noise;
    rows.by_point.middleRows<2>(row) = view->by_point / noise;
    rows.residual.segment<2>(row) = (observations[i].pixel - view->pixel) / noise;
    creep.push_back(pixels.creep_px / noise);
    row += 2;
  }
  if (pixels.creep_px > 0) Whiten(creep, rows);
  return rows;
}

SplitRows SplitOffPoint(const TrackRows& rows) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rows.by_point);
  const auto turn = qr.householderQ().adjoint();
  const Eigen::MatrixXd by_state = turn * rows.by_state;
  const Eigen::VectorXd residual = turn * rows.residual;
  const Eigen::Index free = residual.size() - 3;
  SplitRows split;
  split.point_by_state = by_state.topRows<3>();
  split.by_point = qr.matrixQR().topRows<3>().triangularView<Eigen::Upper>();
  split.point_residual = residual.head<3>();
  split.by_state = by_state.bottomRows(free);
  split.residual = residual.tail(free);
  return split;
}

void Compress(Eigen::MatrixXd& jacobian, Eigen::VectorXd& residual) {
  const Eigen::Index columns = jacobian.cols();
  if (jacobian.rows() <= columns) return;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(jacobian);
  const Eigen::VectorXd turned = qr.householderQ().adjoint() * residual;
  residual = turned.head(columns);
  jacobian = qr.matrixQR().topRows(columns).triangularView<Eigen::Upper>();
}

}  // namespace plumbline
