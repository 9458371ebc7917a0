// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/joint_solution.h"

#include <algorithm>
#include <cmath>

#include "engine/geometry/angles.h"
#include "engine/geometry/symmetric_matrix.h"

namespace plumbline {
namespace {

constexpr double kBaseStd_m = 0.005;     ///< Of a model's base, and of the floor where it stands.
constexpr double kUnknownFloor_m = 100;  ///< Standard deviation where no floor is known.
constexpr double kOffFloor_m = 0.1;      ///< So far from the others' an object has another one.
constexpr double kContactStd_m = 0.002;
constexpr double kTouching_m = 0.01;  ///< Models are not better than this.
constexpr int kMostRounds = 12;

/// A row of the normal equations: `value` is what the combination of moves should be.
struct Row {
  std::vector<std::pair<Eigen::Index, Eigen::Vector3d>> shifts;  ///< By object.
  double of_floor = 0;
  double value = 0, std = 1;
};

class Solver {
 public:
  Solver(std::span<const MeasuredObject> objects, const MapFrame& map, const MapperOptions& options)
      : objects_(objects), map_(map), size_(4 * static_cast<Eigen::Index>(objects.size()) + 1) {
    information_ = Eigen::MatrixXd::Zero(size_, size_);
    for (std::size_t i = 0; i < objects.size(); ++i) {
      information_.block<4, 4>(First(i), First(i)) = InverseOfSymmetric(objects[i].covariance);
    }
    const double floor_std = map.floor_in_world ? map.BaseStd(options) : kUnknownFloor_m;
    information_(size_ - 1, size_ - 1) = 1 / (floor_std * floor_std);
    right_ = Eigen::VectorXd::Zero(size_);
    AddFloor();
  }

  JointSolution Solve() {
    Eigen::MatrixXd information = information_;
    Eigen::VectorXd right = right_;
    Eigen::VectorXd moves = SolveSymmetric(information, right);
    for (int round = 0; round < kMostRounds; ++round) {
      const std::vector<Row> contacts = Contacts(moves);
      if (contacts.empty()) break;
      for (const Row& row : contacts) Add(row, information, right);
      moves = SolveSymmetric(information, right);
    }
    JointSolution solution;
    const Eigen::MatrixXd covariance = InverseOfSymmetric(information_);
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      solution.poses.push_back(Moved(i, moves));
      solution.covariances.emplace_back(covariance.block<4, 4>(First(i), First(i)));
    }
    solution.floor_objects = on_floor_;
    solution.floor_height_m = moves[size_ - 1];
    solution.floor_std_m = std::sqrt(covariance(size_ - 1, size_ - 1));
    return solution;
  }

 private:
  static Eigen::Index First(std::size_t object) { return 4 * static_cast<Eigen::Index>(object); }

  /// Above the level that it stands on.
  double Height(const PoseHypothesis& pose) const {
    if (map_.floor_in_world) return map_.BaseHeight(pose) - map_.StandingOf(pose).height_m;
    return map_.upright.up_in_world().dot(map_.WorldFromObject(pose).translation());
  }

  void AddFloor() {
    std::vector<double> heights;
    for (const MeasuredObject& object : objects_) {
      if (object.on_floor) heights.push_back(Height(object.pose));
    }
    if (heights.empty()) return;
    std::vector<double> sorted = heights;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<long>(sorted.size() / 2),
                     sorted.end());
    const double median = sorted[sorted.size() / 2];
    std::size_t next = 0;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      if (!objects_[i].on_floor) continue;
      const double height = heights[next++];
      if (std::abs(height - median) > kOffFloor_m) continue;
      ++on_floor_;
      const double level_std = map_.floor_in_world ? map_.StandingOf(objects_[i].pose).std_m : 0.0;
      Add({{{First(i), map_.upright.up_in_world()}},
           -1,
           -height,
           std::hypot(kBaseStd_m, level_std)},
          information_, right_);
    }
  }

  static void Add(const Row& row, Eigen::MatrixXd& information, Eigen::VectorXd& right) {
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(right.size());
    for (const auto& [first, shift] : row.shifts) direction.segment<3>(first) = shift;
    direction[direction.size() - 1] = row.of_floor;
    const double weight = 1 / (row.std * row.std);
    information += weight * direction * direction.transpose();
    right += weight * row.value * direction;
  }

  PoseHypothesis Moved(std::size_t i, const Eigen::VectorXd& moves) const {
    PoseHypothesis pose = objects_[i].pose;
    pose.center_in_world += moves.segment<3>(First(i));
    pose.azimuth_rad = WrapAngle(pose.azimuth_rad + moves[First(i) + 3]);
    return pose;
  }

  std::vector<Row> Contacts(const Eigen::VectorXd& moves) const {
    std::vector<Row> rows;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      for (std::size_t j = i + 1; j < objects_.size(); ++j) {
        if (objects_[i].solid == nullptr || objects_[j].solid == nullptr) continue;
        const std::optional<Contact> contact =
            FindContact(*objects_[i].solid, map_.WorldFromObject(Moved(i, moves)),
                        *objects_[j].solid, map_.WorldFromObject(Moved(j, moves)));
        if (!contact || contact->depth_m < kTouching_m) continue;
        const Eigen::Vector3d& n = contact->direction;
        const double apart = n.dot(moves.segment<3>(First(i)) - moves.segment<3>(First(j)));
        rows.push_back(
            {{{First(i), n}, {First(j), -n}}, 0, apart + contact->depth_m, kContactStd_m});
      }
    }
    return rows;
  }

  std::span<const MeasuredObject> objects_;
  const MapFrame& map_;
  Eigen::Index size_;
  Eigen::MatrixXd information_;
  Eigen::VectorXd right_;
  int on_floor_ = 0;
};

}  // namespace

JointSolution SolveJointly(std::span<const MeasuredObject> objects, const MapFrame& map,
                           const MapperOptions& options) {
  return Solver(objects, map, options).Solve();
}

}  // namespace plumbline
