// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/landmark_loops.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iterator>
#include <set>
#include <utility>

#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include "engine/base/json_text.h"
#include "engine/vio/chi_square_gate.h"
#include "engine/vio/drift.h"

namespace plumbline {
namespace {

constexpr std::int64_t kNodeStepNs = 400'000'000;  ///< Between poses of the graph.
constexpr double kDoubtProbability = 0.99;         ///< Farther off, an edge is given up.
constexpr int kEdgeDof = 4;
constexpr double kFarthest_m = 1e6;  ///< Of what a run file may say.

double YawOf(const Eigen::Matrix3d& turn) {
  return std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
}

template <typename Matrix>
nlohmann::json NumbersOf(const Matrix& matrix) {
  return std::vector<double>(matrix.data(), matrix.data() + matrix.size());
}

template <typename Matrix>
void Take(const nlohmann::json& numbers, Matrix& matrix) {
  const auto values = numbers.get<std::vector<double>>();
  if (std::ssize(values) != matrix.size())
    throw nlohmann::json::other_error::create(501, "a matrix of another size", nullptr);
  std::copy(values.begin(), values.end(), matrix.data());
}

}  // namespace

std::string LandmarkEdgesToText(std::span<const LandmarkEdge> edges) {
  nlohmann::json list = nlohmann::json::array();
  for (const LandmarkEdge& edge : edges) {
    list.push_back({{"object", edge.object.value},
                    {"from", edge.from.value},
                    {"to", edge.to.value},
                    {"from_cam_from_to_cam", NumbersOf(edge.from_cam_from_to_cam.matrix())},
                    {"covariance", NumbersOf(edge.covariance)},
                    {"moved_m", edge.moved_m}});
  }
  return nlohmann::json{{"landmarks", list}}.dump();
}

Result<std::vector<LandmarkEdge>> LandmarkEdgesFromText(std::string_view text) {
  std::vector<LandmarkEdge> edges;
  try {
    const nlohmann::json json = ParseJson(text);
    for (const nlohmann::json& item : json.at("landmarks")) {
      LandmarkEdge edge;
      edge.object = ObjectId{IntFromJson(item.at("object"))};
      edge.from = PoseId{IntFromJson(item.at("from"))};
      edge.to = PoseId{IntFromJson(item.at("to"))};
      Take(item.at("from_cam_from_to_cam"), edge.from_cam_from_to_cam.matrix());
      Take(item.at("covariance"), edge.covariance);
      edge.moved_m = item.at("moved_m").get<double>();
      const bool sane = edge.from_cam_from_to_cam.matrix().cwiseAbs().maxCoeff() < kFarthest_m &&
                        edge.covariance.cwiseAbs().maxCoeff() < kFarthest_m &&
                        edge.covariance.llt().info() == Eigen::Success;
      if (!sane) return Error{ErrorCode::kCorrupt, "a landmark whose numbers cannot be"};
      edges.push_back(edge);
    }
  } catch (const std::exception&) {  // of another type, or numbers that do not fit
    return Error{ErrorCode::kCorrupt, "landmarks that are not as this version writes them"};
  }
  return edges;
}

std::string DescribeLandmarkEdges(std::span<const LandmarkEdge> edges) {
  std::string text;
  for (const LandmarkEdge& edge : edges) {
    char part[100];
    std::snprintf(part, sizeof(part), "%sobject %d was seen %.1f cm from where it stood",
                  text.empty() ? "poses corrected: " : ", ", edge.object.value, 100 * edge.moved_m);
    text += part;
  }
  return text;
}

LandmarkLoops::LandmarkLoops(const LoopOptions& options) : options_(options) {}

void LandmarkLoops::See(const PoseEstimate& told) { told_[told.id.value] = told; }

bool LandmarkLoops::Add(std::span<const LandmarkEdge> edges) {
  bool any = false;
  for (const LandmarkEdge& edge : edges) {
    if (told_.count(edge.from.value) == 0 || told_.count(edge.to.value) == 0 ||
        edge.from.value >= edge.to.value)
      continue;
    edges_.push_back(edge);
    any = true;
  }
  if (any) {
    turns_.emplace_back().after = PoseId{told_.rbegin()->first};
    Solve();
  }
  return any;
}

void LandmarkLoops::Refresh() {
  if (!turns_.empty()) Solve();
}

void LandmarkLoops::Solve() {
  std::set<int> wanted;
  for (const LandmarkEdge& edge : edges_) {
    wanted.insert(edge.from.value);
    wanted.insert(edge.to.value);
  }
  wanted.insert(told_.rbegin()->first);
  std::vector<const PoseEstimate*> nodes;
  std::map<int, int> node_of;
  for (const auto& [id, pose] : told_) {
    if (!nodes.empty() && wanted.count(id) == 0 &&
        pose.stamp_ns - nodes.back()->stamp_ns < kNodeStepNs)
      continue;
    node_of[id] = static_cast<int>(nodes.size());
    nodes.push_back(&pose);
  }
  PoseGraph graph(ChiSquareGate(kDoubtProbability)(kEdgeDof));
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const PoseEstimate& pose = *nodes[i];
    graph.AddPose({0, pose.world_from_cam.translation()});
    if (i == 0) continue;
    const PoseEstimate& last = *nodes[i - 1];
    GraphEdge edge;
    edge.from = static_cast<int>(i) - 1;
    edge.to = static_cast<int>(i);
    edge.step = pose.world_from_cam.translation() - last.world_from_cam.translation();
    edge.covariance = DriftBetween(last.world_from_cam.translation(), last.uncertainty.drift,
                                   pose.world_from_cam.translation(), pose.uncertainty.drift,
                                   options_.loop_drift_factor);
    graph.AddEdge(edge);
  }
  for (const LandmarkEdge& landmark : edges_) {
    const PoseEstimate& from = told_.at(landmark.from.value);
    const PoseEstimate& to = told_.at(landmark.to.value);
    const Eigen::Isometry3d seen = from.world_from_cam * landmark.from_cam_from_to_cam;
    GraphEdge edge;
    edge.from = node_of.at(landmark.from.value);
    edge.to = node_of.at(landmark.to.value);
    edge.step = seen.translation() - from.world_from_cam.translation();
    edge.yaw_rad = YawOf(seen.linear() * to.world_from_cam.linear().transpose());
    edge.covariance = landmark.covariance;
    edge.doubtful = true;
    graph.AddEdge(edge);
  }
  graph.Optimise();
  std::vector<Eigen::Matrix4d> covariances = graph.Marginals();
  const Eigen::Vector3d begin = nodes.front()->world_from_cam.translation();
  std::vector<TrajectoryMoves::Node> corrected;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const GraphPose& pose = graph.poses()[i];
    covariances[i] += HandedOn(begin, nodes.front()->uncertainty.drift, pose.position_in_world);
    corrected.push_back({nodes[i]->stamp_ns, nodes[i]->world_from_cam.translation(), pose});
  }
  correction_ = TrajectoryCorrection(std::move(corrected), std::move(covariances));
  const PoseEstimate& newest = told_.rbegin()->second;
  Turn& turn = turns_.back();
  turn.move = correction_.At(newest.stamp_ns, newest.world_from_cam.translation());
  turn.of_told = newest.uncertainty.drift;
  turn.corrected = correction_.CovarianceAt(newest.stamp_ns, newest.uncertainty.drift);
}

PoseEstimate LandmarkLoops::AtItsTime(const PoseEstimate& told) const {
  const auto next =
      std::lower_bound(turns_.begin(), turns_.end(), told.id.value,
                       [](const Turn& turn, int id) { return turn.after.value < id; });
  if (next == turns_.begin()) return told;
  const Turn& turn = *std::prev(next);
  PoseEstimate pose = told;
  pose.world_from_cam = turn.move * told.world_from_cam;
  PoseCovariance by = PoseCovariance::Zero();
  by.topLeftCorner<3, 3>() = by.bottomRightCorner<3, 3>() = turn.move.linear();
  pose.uncertainty.drift =
      turn.corrected + by * (told.uncertainty.drift - turn.of_told) * by.transpose();
  pose.epoch += static_cast<int>(next - turns_.begin());
  return pose;
}

PoseEstimate LandmarkLoops::Now(const PoseEstimate& told) const {
  if (turns_.empty() || told.id.value > turns_.back().after.value) return AtItsTime(told);
  return Known(told.id).value_or(told);
}

std::optional<PoseEstimate> LandmarkLoops::Known(PoseId id) const {
  const auto found = told_.find(id.value);
  if (found == told_.end()) return std::nullopt;
  PoseEstimate pose = found->second;
  if (turns_.empty()) return pose;
  const PoseEstimate& told = found->second;
  pose.world_from_cam =
      correction_.At(told.stamp_ns, told.world_from_cam.translation()) * told.world_from_cam;
  pose.uncertainty.drift = correction_.CovarianceAt(told.stamp_ns, told.uncertainty.drift);
  pose.epoch += static_cast<int>(turns_.size());
  return pose;
}

std::vector<PoseEstimate> LandmarkLoops::Known() const {
  std::vector<PoseEstimate> poses;
  for (const auto& [id, told] : told_) poses.push_back(*Known(PoseId{id}));
  return poses;
}

}  // namespace plumbline
