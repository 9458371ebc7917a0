// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/vio_filter.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"
#include "engine/base/timer.h"
#include "engine/vio/one_point_ransac.h"
#include "engine/vio/point_view.h"
#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

/// A camera's move that is this many times its uncertainty is one [standard deviations].
constexpr double kCertainBaseline = 3;
/// Where the move is less certain, a depth must be clearer than max_depth_spread: of a camera that
/// only turns, noise gives one point in twenty a depth of two standard deviations.
constexpr double kClearDepthSpread = 0.2;

/// How a velocity moves with (phi, xi_v): v = Exp(phi) v^ + xi_v.
Eigen::Matrix<double, 3, 6> VelocityByState(const Eigen::Vector3d& velocity_in_world) {
  Eigen::Matrix<double, 3, 6> by_state;
  by_state << -Hat(velocity_in_world), Eigen::Matrix3d::Identity();
  return by_state;
}

double MedianOf(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

VioFilter::VioFilter(const Camera& camera, const ImuCalibration& imu, const VioOptions& options)
    : camera_(camera),
      options_(options),
      noise_{options.imu_noise_factor * imu.gyro_noise_density,
             options.imu_noise_factor * imu.accel_noise_density,
             std::min(imu.gyro_bias_walk, options.max_gyro_walk),
             std::min(imu.accel_bias_walk, options.max_accel_walk), imu.gravity_m_s2},
      jitter_rad_(options.image_jitter_px / camera.pinhole.fx),
      creep_rad_(options.creep_px / camera.pinhole.fx),
      pixels_{options.pixel_noise_px, options.blur_noise, options.creep_px,
              camera.rolling_shutter_s, static_cast<double>(camera.pinhole.height)},
      gate_(options.gate_probability),
      triangulation_{options.pixel_noise_px, options.min_depth_m, options.max_depth_m,
                     options.max_depth_spread},
      tracks_(camera, options.max_tracks) {}

void VioFilter::Start(const FilterState& state) {
  state_ = state;
  tracks_.Clear();
  TakeLens();
}

void VioFilter::TakeLens() {
  pixels_.rolling_shutter_s = state_.lens()[kReadOut];
  if (!options_.estimate_intrinsics) return;
  camera_ = camera_.With(state_.lens().head<8>());
  tracks_.SetCamera(camera_);
}

ColumnLayout VioFilter::Layout() const {
  return ColumnLayout(state_, options_.estimate_intrinsics || options_.estimate_rolling_shutter);
}

double VioFilter::FlowOf(const TrackedImage& image) {
  std::vector<double> moved;
  std::map<std::int64_t, Eigen::Vector2d> present;
  for (const TrackedPoint& point : image.points) {
    present.emplace(point.id, point.pixel);
    const auto before = last_pixels_.find(point.id);
    if (before != last_pixels_.end()) moved.push_back((point.pixel - before->second).norm());
  }
  last_pixels_ = std::move(present);
  return MedianOf(std::move(moved));
}

FilterStep VioFilter::Step(const TrackedImage& image, const ImuBuffer& imu, bool resting) {
  FilterStep step;
  Stopwatch watch;
  Propagate(image, imu, step);
  std::map<std::int64_t, int> kept;
  for (const StatePoint& point : state_.points()) kept[point.track] = point.row;
  tracks_.Add(image, state_.clones().back().id, kept);
  step.propagate_ms = watch.Lap();

  UpdateWithPoints(image, step);
  // A velocity that no rest explains: points that set off have hardly wandered yet.
  resting = resting && MayBeAtRest();
  std::vector<std::pair<std::int64_t, Track>> for_state, used_up = TakeEnded();
  if (!resting) TakeFull(for_state, used_up);
  UpdateWithTracks(used_up, step);
  if (resting && options_.zero_velocity) {
    UpdateAtRest();
    UpdateTurnAtRest(step);
  }
  AddPoints(for_state, step);
  Marginalise(resting);
  TakeLens();
  step.points = static_cast<int>(state_.points().size());
  step.tracks = static_cast<int>(tracks_.tracks().size()) + step.points;
  step.update_ms = watch.Lap();
  return step;
}

void VioFilter::Propagate(const TrackedImage& image, const ImuBuffer& imu, FilterStep& step) {
  const std::int64_t target = image.stamp_ns + Nanoseconds(state_.time_offset_s());
  const std::vector<ImuSegment> segments = imu.Between(state_.inertial().stamp_ns, target);
  IntegrationNoise noise = noise_;
  const ImuNoise shaken = imu.noise();
  noise.gyro_density = std::max(noise.gyro_density, options_.vibration_share * shaken.gyro_density);
  noise.accel_density =
      std::max(noise.accel_density, options_.vibration_share * shaken.accel_density);
  if (!segments.empty()) state_.Propagate(Integrate(state_.inertial(), segments, noise));
  for (const ImuSegment& segment : segments) {
    if (segment.flaw == ImuFlaw::kGap) step.imu_gap_s += segment.seconds();
    if (segment.flaw == ImuFlaw::kSaturated) step.imu_saturated_s += segment.seconds();
  }
  const auto reading = imu.At(state_.inertial().stamp_ns);
  if (reading) angular_velocity_ = reading->angular_velocity_rad_s - state_.inertial().gyro_bias;
  state_.AddClone(image.stamp_ns, angular_velocity_, FlowOf(image), jitter_rad_,
                  options_.image_jitter_m);
}

bool VioFilter::PassesGate(const Eigen::MatrixXd& jacobian, std::span<const RowRange> rows,
                           const Eigen::VectorXd& residual, FilterStep& step) const {
  const bool passes = CountInnovation(state_.Projected(jacobian, rows), residual, step);
  ++(passes ? step.accepted : step.rejected);
  return passes;
}

bool VioFilter::CountInnovation(Eigen::MatrixXd innovation, const Eigen::VectorXd& residual,
                                FilterStep& step) const {
  innovation.diagonal().array() += 1;
  const double nis = residual.dot(innovation.llt().solve(residual));
  const int dof = static_cast<int>(residual.size());
  if (nis < 10 * dof) {  // a mismatch says nothing of the filter
    step.nis += nis;
    step.nis_dof += dof;
  }
  return nis < gate_(dof);
}

std::optional<TriangulatedPoint> VioFilter::TriangulateTrack(const Track& track) const {
  std::vector<Sight> sights;
  for (const Observation& o : track.observations) {
    const PoseClone* clone = state_.FindClone(o.clone);
    PLB_CHECK(clone != nullptr);
    sights.push_back(
        {pixels_.WorldFromBody(*clone, o.pixel.y()) * state_.body_from_cam(), o.pixel, o.ray});
  }
  TriangulationOptions options = triangulation_;
  if (!BaselineIsCertain(track))
    options.max_depth_spread = std::min(options.max_depth_spread, kClearDepthSpread);
  return Triangulate(camera_, sights, options);
}

bool VioFilter::BaselineIsCertain(const Track& track) const {
  const PoseClone* first = state_.FindClone(track.observations.front().clone);
  const PoseClone* last = state_.FindClone(track.observations.back().clone);
  PLB_CHECK(first != nullptr && last != nullptr);
  // The plain error of a clone's position is xi_p + phi x p.
  Eigen::Matrix<double, 3, 12> jacobian;
  const auto by_clone = [](const PoseClone& clone) {
    const Eigen::Vector3d p = clone.world_from_body.translation();
    Eigen::Matrix<double, 3, 6> block;
    block << 0, p.z(), -p.y(), 1, 0, 0, -p.z(), 0, p.x(), 0, 1, 0, p.y(), -p.x(), 0, 0, 0, 1;
    return block;
  };
  jacobian << -by_clone(*first), by_clone(*last);
  const RowRange rows[] = {{first->row, kPoseSize}, {last->row, kPoseSize}};
  Eigen::Matrix3d covariance = state_.Projected(jacobian, rows);
  covariance.diagonal().array() += 1e-10;
  const Eigen::Vector3d baseline = last->world_from_body * state_.body_from_cam().translation() -
                                   first->world_from_body * state_.body_from_cam().translation();
  return baseline.dot(covariance.ldlt().solve(baseline)) > kCertainBaseline * kCertainBaseline;
}

std::vector<std::pair<std::int64_t, Track>> VioFilter::TakeEnded() {
  std::vector<std::pair<std::int64_t, Track>> ended;
  std::erase_if(tracks_.tracks(), [&](const auto& entry) {
    const Track& track = entry.second;
    if (track.seen) return false;
    if (static_cast<int>(track.observations.size()) >= options_.min_observations)
      ended.emplace_back(entry.first, track);
    return true;
  });
  return ended;
}

void VioFilter::TakeFull(std::vector<std::pair<std::int64_t, Track>>& for_state,
                         std::vector<std::pair<std::int64_t, Track>>& used_up) {
  const auto& clones = state_.clones();
  if (static_cast<int>(clones.size()) <= options_.window_clones) return;
  std::vector<std::pair<int, std::int64_t>> full;  // the oldest tracks first
  for (const auto& [id, track] : tracks_.tracks()) {
    if (!track.observations.empty() && track.observations.front().clone == clones.front().id &&
        static_cast<int>(track.observations.size()) >= options_.min_observations)
      full.emplace_back(-track.age, id);
  }
  std::sort(full.begin(), full.end());
  int slots = options_.state_features - static_cast<int>(state_.points().size());
  for (const auto& [age, id] : full) {
    Track& track = tracks_.tracks()[id];
    const bool whole = track.observations.size() + 1 >= clones.size();
    if (slots > 0 && whole) {
      --slots;
      for_state.emplace_back(id, track);
    } else {
      used_up.emplace_back(id, track);
    }
  }
}

void VioFilter::UpdateWithTracks(const std::vector<std::pair<std::int64_t, Track>>& tracks,
                                 FilterStep& step) {
  const ColumnLayout layout = Layout();
  std::vector<SplitRows> parts;
  for (const auto& [id, track] : tracks) {
    const auto point = TriangulateTrack(track);
    if (!point) {  // a living track keeps its sights and may see more
      ++step.without_depth;
      continue;
    }
    const auto rows = RowsOfTrack(camera_, state_, layout, track.observations, point->used,
                                  point->point_in_world, pixels_);
    const auto living = tracks_.tracks().find(id);
    if (living != tracks_.tracks().end()) living->second.observations.clear();
    if (!rows || rows->residual.size() < 4) continue;
    SplitRows split = SplitOffPoint(*rows);
    if (!PassesGate(split.by_state, layout.rows(), split.residual, step)) continue;
    finished_.push_back({id, point->point_in_world});
    parts.push_back(std::move(split));
  }
  UpdateWithParts(parts, layout);
}

void VioFilter::UpdateWithParts(const std::vector<SplitRows>& parts, const ColumnLayout& layout) {
  Eigen::Index total = 0;
  for (const SplitRows& part : parts) total += part.residual.size();
  if (total == 0) return;
  Eigen::MatrixXd jacobian(total, layout.size());
  Eigen::VectorXd residual(total);
  Eigen::Index row = 0;
  for (const SplitRows& part : parts) {
    jacobian.middleRows(row, part.residual.size()) = part.by_state;
    residual.segment(row, part.residual.size()) = part.residual;
    row += part.residual.size();
  }
  Compress(jacobian, residual);
  state_.Update(jacobian, layout.rows(), residual, NoiseOf::kImages);
}

void VioFilter::AddPoints(const std::vector<std::pair<std::int64_t, Track>>& tracks,
                          FilterStep& step) {
  for (const auto& [id, track] : tracks) {
    const ColumnLayout layout = Layout();
    const auto triangulated = TriangulateTrack(track);
    if (!triangulated) continue;
    const PoseClone& anchor = state_.clones().back();
    const auto chart =
        ChartPoint(state_.body_from_cam(), anchor.world_from_body, triangulated->point_in_world);
    if (!chart) continue;
    const Eigen::Vector3d value = chart->bearing_and_inverse_depth;
    const AnchoredPoint placed = PlacePoint(state_.body_from_cam(), anchor.world_from_body, value);
    auto rows = RowsOfTrack(camera_, state_, layout, track.observations, triangulated->used,
                            placed.point_in_world, pixels_);
    if (!rows) continue;
    rows->by_state.middleCols<6>(layout.camera()) += rows->by_point * placed.by_camera;
    rows->by_state.middleCols<6>(layout.clone(anchor.id)) += rows->by_point * placed.by_anchor;
    rows->by_point = (rows->by_point * placed.by_value).eval();
    const SplitRows split = SplitOffPoint(*rows);
    tracks_.Erase(id);
    if (!PassesGate(split.by_state, layout.rows(), split.residual, step)) continue;
    StatePoint point;
    point.track = id;
    point.anchor = anchor.id;
    point.bearing_and_inverse_depth = value;
    state_.AddPoint(point, split.point_by_state, layout.rows(), split.by_point,
                    split.point_residual);
    state_.Update(split.by_state, layout.rows(), split.residual, NoiseOf::kImages);
  }
}

std::optional<VioFilter::PointSight> VioFilter::SeePoint(const StatePoint& point,
                                                         const Eigen::Vector2d& pixel,
                                                         const ColumnLayout& layout,
                                                         int column) const {
  const PoseClone* anchor = state_.FindClone(point.anchor);
  PLB_CHECK(anchor != nullptr);
  const PoseClone& present = state_.clones().back();
  if (point.bearing_and_inverse_depth.z() <= 0) return std::nullopt;
  const AnchoredPoint placed =
      PlacePoint(state_.body_from_cam(), anchor->world_from_body, point.bearing_and_inverse_depth);
  const auto view = ViewPoint(camera_, state_.body_from_cam(),
                              pixels_.WorldFromBody(present, pixel.y()), placed.point_in_world);
  if (!view) return std::nullopt;
  PointSight sight{point.track, pixel, column, Eigen::MatrixXd::Zero(2, layout.size()), {}};
  auto& jacobian = sight.by_state;
  jacobian.middleCols<6>(layout.camera()) = view->by_camera + view->by_point * placed.by_camera;
  if (layout.has_lens()) {
    jacobian.middleCols<kLensSize>(layout.lens()) =
        SightByLens(camera_, pixels_, *view, present, pixel.y());
  }
  jacobian.middleCols<6>(layout.clone(anchor->id)) += view->by_point * placed.by_anchor;
  jacobian.middleCols<6>(layout.clone(present.id)) += view->by_pose;
  jacobian.middleCols<3>(column) = view->by_point * placed.by_value;
  const double noise = pixels_.NoiseIn(present) * std::sqrt(1 + options_.age_noise * point.age);
  jacobian /= noise;
  sight.residual = (pixel - view->pixel) / noise;
  return sight;
}

std::pair<Eigen::MatrixXd, Eigen::VectorXd> VioFilter::Stacked(std::span<const PointSight> sights) {
  const auto rows = 2 * static_cast<Eigen::Index>(sights.size());
  Eigen::MatrixXd jacobian(rows, sights.front().by_state.cols());
  Eigen::VectorXd residual(rows);
  Eigen::Index row = 0;
  for (const PointSight& sight : sights) {
    jacobian.middleRows<2>(row) = sight.by_state;
    residual.segment<2>(row) = sight.residual;
    row += 2;
  }
  return {std::move(jacobian), std::move(residual)};
}

void VioFilter::UpdateWithSights(std::span<const PointSight> sights, const ColumnLayout& layout) {
  if (sights.empty()) return;
  const auto [jacobian, residual] = Stacked(sights);
  state_.Update(jacobian, layout.rows(), residual, NoiseOf::kImages);
}

std::vector<std::int64_t> VioFilter::UpdateWithAgreeing(std::vector<PointSight> sights,
                                                        const ColumnLayout& layout,
                                                        FilterStep& step) {
  if (sights.empty()) return {};
  const auto [jacobian, residual] = Stacked(sights);
  const Eigen::MatrixXd projected = state_.Projected(jacobian, layout.rows());
  std::vector<bool> used(sights.size());
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(2 * i);
    used[i] = CountInnovation(projected.block<2, 2>(row, row), sights[i].residual, step);
  }
  if (options_.one_point_ransac) used = OnePointConsensus(residual, projected, gate_(2));
  std::vector<PointSight> agreeing, others;
  for (std::size_t i = 0; i < sights.size(); ++i)
    (used[i] ? agreeing : others).push_back(std::move(sights[i]));
  UpdateWithSights(agreeing, layout);
  step.accepted += static_cast<int>(agreeing.size());
  // What only looked wrong because the state was: a point that is near, of a camera that has moved
  // otherwise than expected.
  std::vector<PointSight> rescued;
  std::vector<std::int64_t> turned_away;
  for (const PointSight& other : others) {
    const StatePoint& point = *FindPoint(other.track);
    const auto again = options_.one_point_ransac
                           ? SeePoint(point, other.pixel, layout, other.column)
                           : std::nullopt;
    FilterStep ignored;
    if (again && CountInnovation(state_.Projected(again->by_state, layout.rows()), again->residual,
                                 ignored)) {
      rescued.push_back(*again);
    } else {
      turned_away.push_back(other.track);
    }
  }
  UpdateWithSights(rescued, layout);
  step.accepted += static_cast<int>(rescued.size());
  step.rejected += static_cast<int>(turned_away.size());
  return turned_away;
}

void VioFilter::UpdateWithPoints(const TrackedImage& image, FilterStep& step) {
  constexpr int kMaxRejected = 3;
  std::map<std::int64_t, Eigen::Vector2d> seen;
  for (const TrackedPoint& point : image.points) seen.emplace(point.id, point.pixel);
  // What is followed creeps over the surface: the point itself moves.
  ColumnLayout layout = Layout();
  std::vector<int> columns;
  for (const StatePoint& point : state_.points()) {
    columns.push_back(layout.AddPoint(point));
    state_.Creep({point.row, 2}, creep_rad_ * creep_rad_);
  }
  std::vector<PointSight> sights;
  std::vector<std::int64_t> lost;
  for (std::size_t i = 0; i < state_.points().size(); ++i) {
    StatePoint& point = state_.points()[i];
    const auto pixel = seen.find(point.track);
    auto sight =
        pixel == seen.end() ? std::nullopt : SeePoint(point, pixel->second, layout, columns[i]);
    if (sight) {
      ++point.age;
      sights.push_back(std::move(*sight));
    } else {
      lost.push_back(point.track);
    }
  }
  const std::vector<std::int64_t> turned_away = UpdateWithAgreeing(std::move(sights), layout, step);
  for (StatePoint& point : state_.points()) {
    const bool rejected =
        std::find(turned_away.begin(), turned_away.end(), point.track) != turned_away.end();
    point.rejected = rejected ? point.rejected + 1 : 0;
    // The update may have moved one behind.
    if (point.rejected >= kMaxRejected ||
        point.bearing_and_inverse_depth.z() <= 0.5 / options_.max_depth_m ||
        point.age > options_.max_point_age)
      lost.push_back(point.track);
  }
  std::sort(lost.begin(), lost.end());
  lost.erase(std::unique(lost.begin(), lost.end()), lost.end());
  for (const std::int64_t track : lost) {
    const StatePoint* point = FindPoint(track);
    const PoseClone* anchor = state_.FindClone(point->anchor);
    if (point->rejected == 0 && point->bearing_and_inverse_depth.z() > 1 / options_.max_depth_m) {
      finished_.push_back({track, PlacePoint(state_.body_from_cam(), anchor->world_from_body,
                                             point->bearing_and_inverse_depth)
                                      .point_in_world});
    }
    state_.RemovePoint(track);
  }
}

const StatePoint* VioFilter::FindPoint(std::int64_t track) const {
  const auto found = std::find_if(state_.points().begin(), state_.points().end(),
                                  [&](const StatePoint& point) { return point.track == track; });
  PLB_CHECK(found != state_.points().end());
  return &*found;
}

bool VioFilter::MayBeAtRest() const {
  const Eigen::Vector3d v = state_.inertial().velocity_in_world;
  const Eigen::Matrix<double, 3, 6> by_state = VelocityByState(v);
  Eigen::Matrix3d innovation =
      by_state * state_.covariance().block<6, 6>(kPhi, kPhi) * by_state.transpose();
  innovation.diagonal().array() += options_.zero_velocity_std_m_s * options_.zero_velocity_std_m_s;
  return v.dot(innovation.llt().solve(v)) <= gate_(3);
}

void VioFilter::UpdateAtRest() {
  const double std = options_.zero_velocity_std_m_s;
  const Eigen::Vector3d v = state_.inertial().velocity_in_world;
  const RowRange rows[] = {{kPhi, 6}};
  state_.Update(VelocityByState(v) / std, rows, -v / std, NoiseOf::kRest);
}

void VioFilter::UpdateTurnAtRest(FilterStep& step) {
  // Without parallax a track has no depth, but its depth does not matter either: any will do. The
  // first sight is used again and again, which the noise makes up for.
  constexpr double kAnyDepth = 3, kNoiseFactor = 3;
  PixelModel pixels = pixels_;
  pixels.noise_px *= kNoiseFactor;
  pixels.creep_px = 0;
  const PoseClone& oldest = state_.clones().front();
  const ColumnLayout layout = Layout();
  const Eigen::Isometry3d world_from_cam = oldest.world_from_body * state_.body_from_cam();
  std::vector<SplitRows> parts;
  for (const auto& [id, track] : tracks_.tracks()) {
    if (!track.seen || track.observations.size() < 2 ||
        track.observations.front().clone != oldest.id)
      continue;
    const Observation both[] = {track.observations.front(), track.observations.back()};
    const auto rows = RowsOfTrack(camera_, state_, layout, both, {true, true},
                                  world_from_cam * (kAnyDepth * both[0].ray), pixels);
    if (!rows) continue;
    SplitRows split = SplitOffPoint(*rows);
    if (PassesGate(split.by_state, layout.rows(), split.residual, step))
      parts.push_back(std::move(split));
  }
  UpdateWithParts(parts, layout);
}

void VioFilter::MoveAnchors(std::int64_t from_clone) {
  std::vector<std::int64_t> lost;
  for (StatePoint& point : state_.points()) {
    if (point.anchor != from_clone) continue;
    const PoseClone* old = state_.FindClone(from_clone);
    const PoseClone& next = state_.clones().back();
    const AnchoredPoint placed =
        PlacePoint(state_.body_from_cam(), old->world_from_body, point.bearing_and_inverse_depth);
    const auto chart =
        ChartPoint(state_.body_from_cam(), next.world_from_body, placed.point_in_world);
    if (!chart) {
      lost.push_back(point.track);
      continue;
    }
    Eigen::MatrixXd jacobian(3, 21);
    jacobian << chart->by_camera + chart->by_point * placed.by_camera,
        chart->by_point * placed.by_anchor, chart->by_anchor, chart->by_point * placed.by_value;
    const RowRange rows[] = {{kCamRotation, kPoseSize},
                             {old->row, kPoseSize},
                             {next.row, kPoseSize},
                             {point.row, kPointSize}};
    state_.ChangePoint(point, next.id, chart->bearing_and_inverse_depth, jacobian, rows);
  }
  for (const std::int64_t track : lost) state_.RemovePoint(track);
}

void VioFilter::Marginalise(bool resting) {
  while (static_cast<int>(state_.clones().size()) > options_.window_clones) {
    // At rest the newest poses are alike: the older ones keep their parallax.
    const std::size_t index = resting ? state_.clones().size() - 2 : 0;
    const std::int64_t id = state_.clones()[index].id;
    MoveAnchors(id);
    tracks_.ForgetClone(id);
    state_.RemoveClone(id);
  }
}

}  // namespace plumbline
