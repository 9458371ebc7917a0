// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/loop_closer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "engine/base/timer.h"
#include "engine/geometry/angles.h"
#include "engine/vio/drift.h"
#include "engine/vio/imu_buffer.h"

namespace plumbline {
namespace {

constexpr int kDof = 4;
constexpr int kMaxLooked = 20;        ///< Older key frames that are compared with the newest.
constexpr int kMaxVerified = 3;       ///< Of those, the ones whose pose is sought.
constexpr double kMaxTurnDeg = 60;    ///< Between two views of one place.
constexpr std::size_t kAgreeing = 2;  ///< Key frames that have to say the same.
constexpr int kLetGoShare = 10;       ///< Of key frames, the part that is let go of at once.
constexpr std::size_t kNewest = PlaceFrameMaker::kWaitingKeyFrames;  ///< Are not let go of.
/// After a loop is closed, before the next is sought. Of a large graph it grows with the work of
/// factoring it, which is done some dozen times: loops take a tenth of the time, however many.
constexpr double kPauseS = 2, kPauseOfWorkS = 0.6e-6;

Eigen::Vector4d Squared(double std_m, double std_deg) {
  const double rad = std_deg * kRadPerDeg;
  return {std_m * std_m, std_m * std_m, std_m * std_m, rad * rad};
}

Eigen::Vector3d Axis(const PlaceFrame& key_frame) {
  return (key_frame.world_from_body * key_frame.body_from_cam).linear().col(2);
}

double Seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return static_cast<double>(to_ns - from_ns) * 1e-9;
}

}  // namespace

Eigen::Matrix4d DriftBetween(const PlaceFrame& from, const PlaceFrame& to, double factor) {
  return DriftBetween(from.world_from_body.translation(), from.covariance,
                      to.world_from_body.translation(), to.covariance, factor);
}

LoopCloser::LoopCloser(const Camera& camera, const LoopOptions& options)
    : camera_(camera),
      lens_(camera),
      options_(options),
      gate_(options.loop_gate_probability),
      maker_(camera, options.key_corners),
      graph_(ChiSquareGate(0.99)(kDof)) {
  report_.has_images = true;
}

void LoopCloser::See(const VioMoment& moment) {
  const Stopwatch watch;
  if (!key_frames_.empty()) maker_.AddPoints(moment.points, key_frames_);
  if (!moment.reports.empty() && IsKeyFrame(moment.reports.back())) {
    AddKeyFrame(maker_.Make(moment.picture, moment.tracked, moment.image, moment.reports.back()));
    maker_.AddStatePoints(moment.estimator.filter().state(), key_frames_);
    Search();
  }
  report_.ms += watch.Milliseconds();
}

bool LoopCloser::IsKeyFrame(const VioReport& report) const {
  if (report.phase != VioPhase::kTracking || !report.message.empty()) return false;
  if (key_frames_.empty() || key_frames_.back().stretch != report.stretch) return true;
  const Eigen::Isometry3d moved =
      key_frames_.back().world_from_body.inverse() * report.world_from_body;
  return moved.translation().norm() > options_.key_move_m ||
         Eigen::AngleAxisd(moved.linear()).angle() > options_.key_turn_deg * kRadPerDeg;
}

void LoopCloser::AddKeyFrame(PlaceFrame key_frame) {
  GraphPose pose{0, key_frame.world_from_body.translation()};
  if (!key_frames_.empty()) {
    const PlaceFrame& last = key_frames_.back();
    const GraphPose& corrected = graph_.poses().back();
    const YawMove move = MoveTo(corrected, last.world_from_body.translation());
    pose = {move.yaw_rad, move.AsIsometry() * key_frame.world_from_body.translation()};
    GraphEdge edge;
    edge.from = static_cast<int>(key_frames_.size()) - 1;
    edge.to = edge.from + 1;
    edge.step = key_frame.world_from_body.translation() - last.world_from_body.translation();
    edge.covariance = DriftBetween(last, key_frame, options_.loop_drift_factor);
    graph_.AddPose(pose);
    graph_.AddEdge(edge);
  } else {
    graph_.AddPose(pose);
  }
  key_frames_.push_back(std::move(key_frame));
  ++num_kept_;
  KeepFew();
}

double LoopCloser::TurnBetween(std::size_t one, std::size_t other) const {
  const auto axis = [&](std::size_t i) -> Eigen::Vector3d {
    return Eigen::AngleAxisd(graph_.poses()[i].yaw_rad, Eigen::Vector3d::UnitZ()) *
           Axis(key_frames_[i]);
  };
  return std::acos(std::clamp(axis(one).dot(axis(other)), -1.0, 1.0));
}

double LoopCloser::DistanceBetween(std::size_t one, std::size_t other) const {
  return (graph_.poses()[one].position_in_world - graph_.poses()[other].position_in_world).norm();
}

void LoopCloser::KeepFew() {
  // Seldom and many at once: all are compared with all.
  if (num_kept_ <= options_.key_frames_kept + options_.key_frames_kept / kLetGoShare) return;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i + kNewest < key_frames_.size(); ++i) {
    if (!key_frames_[i].let_go) kept.push_back(i);
  }
  std::vector<std::pair<double, std::size_t>> near;  // each by how far off the nearest older one is
  for (std::size_t i = 1; i < kept.size(); ++i) {
    double nearest = std::numeric_limits<double>::max();
    for (std::size_t j = 0; j < i; ++j) {  // a metre is like a radian
      nearest =
          std::min(nearest, DistanceBetween(kept[i], kept[j]) + TurnBetween(kept[i], kept[j]));
    }
    near.emplace_back(nearest, kept[i]);
  }
  std::sort(near.begin(), near.end());
  const auto excess = static_cast<std::size_t>(num_kept_ - options_.key_frames_kept);
  std::vector<bool> unwanted(key_frames_.size(), false);
  for (std::size_t i = 0; i < std::min(excess, near.size()); ++i, --num_kept_) {
    key_frames_[near[i].second].LetGo();
    unwanted[near[i].second] = true;
  }
  for (const Pending& loop : pending_) {
    unwanted[static_cast<std::size_t>(loop.edge.from)] = false;
    unwanted[static_cast<std::size_t>(loop.edge.to)] = false;
  }
  TakeOut(unwanted);
}

void LoopCloser::TakeOut(const std::vector<bool>& unwanted) {
  const std::vector<int> number = graph_.TakeOut(unwanted);
  std::vector<PlaceFrame> left;
  for (std::size_t i = 0; i < key_frames_.size(); ++i) {
    if (number[i] >= 0) left.push_back(std::move(key_frames_[i]));
  }
  const std::size_t gone = key_frames_.size() - left.size();
  key_frames_ = std::move(left);
  maker_.Renumber(gone);
  report_.key_frames += static_cast<int>(gone);
  for (Pending& loop : pending_) {
    loop.edge.from = number[static_cast<std::size_t>(loop.edge.from)];
    loop.edge.to = number[static_cast<std::size_t>(loop.edge.to)];
  }
}

std::vector<std::pair<int, std::vector<PointMatch>>> LoopCloser::Candidates() const {
  const PlaceFrame& newest = key_frames_.back();
  std::vector<std::pair<double, int>> near;  // by how far off
  for (std::size_t i = 0; i + 1 < key_frames_.size(); ++i) {
    const PlaceFrame& older = key_frames_[i];
    if (Seconds(older.stamp_ns, newest.stamp_ns) < options_.loop_min_age_s) break;
    if (older.let_go) continue;
    const Eigen::Vector4d drift =
        DriftBetween(older, newest, 3 * options_.loop_drift_factor).diagonal().cwiseSqrt();
    const double distance = DistanceBetween(i, key_frames_.size() - 1);
    const double turn = TurnBetween(i, key_frames_.size() - 1);
    if (distance > options_.loop_reach_m + drift.head<3>().norm() ||
        turn > kMaxTurnDeg * kRadPerDeg + drift(3))
      continue;
    near.emplace_back(distance + turn, static_cast<int>(i));
  }
  std::sort(near.begin(), near.end());
  if (near.size() > kMaxLooked) near.resize(kMaxLooked);
  std::vector<std::pair<int, std::vector<PointMatch>>> candidates;
  for (const auto& [off, index] : near) {
    auto matches = MatchPoints(key_frames_[static_cast<std::size_t>(index)], newest);
    if (static_cast<int>(matches.size()) >= options_.loop_min_matches)
      candidates.emplace_back(index, std::move(matches));
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.second.size() > b.second.size(); });
  if (candidates.size() > kMaxVerified) candidates.resize(kMaxVerified);
  return candidates;
}

void LoopCloser::Search() {
  const PlaceFrame& newest = key_frames_.back();
  if (!report_.closures.empty() && Seconds(last_closed_ns_, newest.stamp_ns) < pause_s_) return;
  std::erase_if(pending_, [&](const Pending& loop) {
    const bool late = Seconds(loop.stamp_ns, newest.stamp_ns) > options_.loop_agree_s;
    if (late) ++report_.unconfirmed;
    return late;
  });
  for (const auto& [index, matches] : Candidates()) {
    const PlaceFrame& older = key_frames_[static_cast<std::size_t>(index)];
    const auto place = LocateByPoints(lens_, camera_.pinhole.fx, older, newest, matches, options_);
    if (!place) continue;
    ++report_.alike;
    Pending loop;
    loop.edge.from = index;
    loop.edge.to = static_cast<int>(key_frames_.size()) - 1;
    loop.edge.step = place->position_in_world - older.world_from_body.translation();
    loop.edge.yaw_rad = place->yaw_rad;
    loop.edge.covariance = place->covariance;
    loop.edge.covariance.diagonal() += Squared(options_.loop_std_m, options_.loop_std_deg);
    loop.edge.doubtful = true;
    loop.stamp_ns = newest.stamp_ns;
    loop.inliers = place->inliers;
    const Eigen::Matrix4d drift = graph_.RelativeCovariance(loop.edge.from, loop.edge.to);
    const auto off = [&](double factor) {
      const Eigen::Vector4d error = graph_.ErrorOf(loop.edge);
      const Eigen::Matrix4d expected = factor * factor * drift + loop.edge.covariance;
      return error.dot(expected.ldlt().solve(error));
    };
    if (off(options_.loop_gate_factor / options_.loop_drift_factor) > gate_(kDof)) {
      ++report_.turned_away;
      continue;
    }
    loop.suspect = off(1) > gate_(kDof);
    Weigh(std::move(loop));
    return;
  }
}

void LoopCloser::Weigh(Pending loop) {
  loop.says = graph_.ErrorOf(loop.edge);
  const double heading = graph_.poses()[static_cast<std::size_t>(loop.edge.from)].yaw_rad;
  loop.says.head<3>() =
      Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) * Eigen::Vector3d(loop.says.head<3>());
  std::vector<Pending> agreeing;
  for (const Pending& other : pending_) {
    const Eigen::Vector4d off = loop.says - other.says;
    const Eigen::Matrix4d expected = loop.edge.covariance + other.edge.covariance;
    if (off.dot(expected.ldlt().solve(off)) < gate_(kDof)) agreeing.push_back(other);
  }
  const bool suspect = loop.suspect;
  agreeing.push_back(loop);
  pending_.push_back(std::move(loop));
  if (agreeing.size() < (suspect ? 2 * kAgreeing : kAgreeing)) return;
  pending_.clear();
  Close(agreeing);
}

void LoopCloser::Close(const std::vector<Pending>& loops) {
  const GraphPose before = graph_.poses().back();
  for (const Pending& loop : loops) graph_.AddEdge(loop.edge);
  graph_.Optimise();
  ++report_.epochs;
  const GraphPose& after = graph_.poses().back();
  for (const Pending& loop : loops) {
    LoopClosure closure;
    closure.image = key_frames_[static_cast<std::size_t>(loop.edge.to)].image;
    closure.old_image = key_frames_[static_cast<std::size_t>(loop.edge.from)].image;
    closure.closed_image = key_frames_.back().image;
    closure.inliers = loop.inliers;
    closure.moved_m = (after.position_in_world - before.position_in_world).norm();
    closure.turned_deg =
        std::abs(std::remainder(after.yaw_rad - before.yaw_rad, 2 * M_PI)) * kDegPerRad;
    closure.epoch = report_.epochs;
    report_.closures.push_back(closure);
  }
  last_closed_ns_ = key_frames_.back().stamp_ns;
  pause_s_ = std::max(kPauseS, kPauseOfWorkS * graph_.Work());
}

YawMove LoopCloser::PresentMove() const {
  if (key_frames_.empty()) return {};
  return MoveTo(graph_.poses().back(), key_frames_.back().world_from_body.translation());
}

TrajectoryCorrection LoopCloser::Correction() const {
  if (report_.closures.empty()) return {};
  std::vector<Eigen::Matrix4d> covariances = graph_.Marginals();
  const Eigen::Vector3d& begin = graph_.poses().front().position_in_world;
  std::vector<TrajectoryMoves::Node> nodes;
  for (std::size_t i = 0; i < key_frames_.size(); ++i) {
    const GraphPose& pose = graph_.poses()[i];
    covariances[i] += HandedOn(begin, key_frames_.front().covariance, pose.position_in_world);
    nodes.push_back({key_frames_[i].stamp_ns, key_frames_[i].world_from_body.translation(), pose});
  }
  return TrajectoryCorrection(std::move(nodes), std::move(covariances));
}

LoopReport LoopCloser::Report() const {
  LoopReport report = report_;
  report.key_frames += static_cast<int>(key_frames_.size());
  report.unconfirmed += static_cast<int>(pending_.size());
  std::size_t next = 0;
  for (const GraphEdge& edge : graph_.edges()) {
    if (edge.doubtful) report.closures[next++].trust = graph_.TrustIn(edge);
  }
  for (std::size_t i = 0; i < key_frames_.size(); ++i) {
    const GraphPose& pose = graph_.poses()[i];
    report.last_move_m =
        (pose.position_in_world - key_frames_[i].world_from_body.translation()).norm();
    report.last_turn_deg = std::abs(std::remainder(pose.yaw_rad, 2 * M_PI)) * kDegPerRad;
    report.largest_move_m = std::max(report.largest_move_m, report.last_move_m);
    report.largest_turn_deg = std::max(report.largest_turn_deg, report.last_turn_deg);
    report.bytes += static_cast<double>(key_frames_[i].bytes());
  }
  return report;
}

}  // namespace plumbline
