// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "engine/mapping/bytes.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// What crops of one object said of the shapes of its category, each at four quarter turns
/// (docs/algorithms/crops.md). It tells twins and half turns apart where outlines cannot, and says
/// nothing of where the object is.
class CropBelief {
 public:
  static constexpr std::size_t kTurns = 4;
  static constexpr std::size_t kMostLooks = 12;

  /// Which crops are compared: `turn` quarter turns from where the object first was.
  struct Candidate {
    ModelId label;
    double azimuth_rad = 0;
  };
  /// All labels at all turns; `azimuth_rad` is the object's now.
  std::vector<Candidate> Candidates(std::span<const ModelId> labels, double azimuth_rad) const;

  /// Another look. One in which a candidate could not be judged is no view, and says nothing.
  /// @param likeness  Of Candidates(labels, azimuth_rad), see CropComparer.
  void Add(const Eigen::Isometry3d& world_from_cam, std::span<const ModelId> labels,
           double azimuth_rad, std::span<const std::optional<double>> likeness);

  /// world_from_cam of all looks.
  const std::vector<Eigen::Isometry3d>& looked_from() const { return looked_from_; }
  int views() const { return views_; }
  /// Sum over the views of the likeness, less that of the best candidate; between turns that of
  /// the nearer one, smoothly: fine differences of azimuth are the outlines' business.
  double Likeness(ModelId label, double azimuth_rad) const;

  void Save(ByteWriter& out) const;
  void Restore(ByteReader& in);

 private:
  struct Sum {
    ModelId label;
    std::array<double, kTurns> of_turn{};
  };
  double anchor_rad_ = 0;  ///< The azimuth of turn 0.
  std::vector<Sum> sums_;
  int views_ = 0;
  std::vector<Eigen::Isometry3d> looked_from_;
};

}  // namespace plumbline
