// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "engine/geometry/box.h"
#include "engine/mapping/bytes.h"
#include "engine/mapping/mapper_options.h"

namespace plumbline {

/// Whether something stands still, by where its boxes say that it is: two models of its place on
/// the ground are compared, with velocities that are normal about 0: what moves evenly, and what
/// stands but seems to move as its boxes err alike (docs/algorithms/outdoors.md). Each box is a
/// place with a covariance; of all together sums suffice.
class MotionTest {
 public:
  /// One of fewer may be of something else: they tell nothing.
  static constexpr int kLeastBoxes = 4;

  /// @param box          In the image.
  /// @param place_m      On the ground, in any fixed level axes.
  /// @param information  Inverse of its covariance.
  void Add(std::int64_t stamp_ns, const Box2& box, const Eigen::Vector2d& place_m,
           const Eigen::Matrix2d& information);
  /// log p(places | it moves) - log p(places | it stands); 0 before the fourth box.
  double LogBayesFactor(const MapperOptions& options) const;
  /// log P(it stands | places).
  double LogStanding(const MapperOptions& options) const;
  /// How much less likely the places have made it that it stands; 0 where they have not.
  double LogAgainst(const MapperOptions& options) const;
  /// The velocity that is most likely if it moves [m/s].
  Eigen::Vector2d Velocity(const MapperOptions& options) const;
  int boxes() const { return boxes_; }
  const Box2& last_box() const { return last_box_; }

  void Save(ByteWriter& out) const;
  void Restore(ByteReader& in);

 private:
  /// Of the velocity, once the place is integrated out.
  struct Reduced {
    Eigen::Matrix2d information;
    Eigen::Vector2d pull;  ///< information * velocity
  };
  Reduced OfVelocity() const;

  std::int32_t boxes_ = 0;
  Box2 last_box_;
  std::int64_t first_ns_ = 0;  ///< Sums are about the time and the place of the first box.
  Eigen::Vector2d first_m_{0, 0};
  Eigen::Matrix2d weight_ = Eigen::Matrix2d::Zero(), weight_t_ = Eigen::Matrix2d::Zero(),
                  weight_tt_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d place_ = Eigen::Vector2d::Zero(), place_t_ = Eigen::Vector2d::Zero();
};

}  // namespace plumbline
