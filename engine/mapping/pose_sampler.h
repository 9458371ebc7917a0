// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "engine/mapping/hypothesis_scorer.h"
#include "engine/mapping/mapper_options.h"
#include "engine/mapping/particle_set.h"

namespace plumbline {

/// What a target density says of one hypothesis.
struct Judgement {
  double log_target =
      0;             ///< Unnormalised; of (label, centre in world [m], azimuth [rad], log-scale).
  float memory = 0;  ///< Of it, what the object's remembered views say, before scaling.
  float phi_cnn = 0, phi_edge = 0;  ///< Of it, both terms in the present frame.
};
using Target = std::function<std::vector<Judgement>(std::span<const PoseHypothesis>)>;

/// Equally weighted draws and what the target says of each.
struct Population {
  std::vector<PoseHypothesis> hypotheses;
  std::vector<Judgement> judged;
  std::vector<std::uint16_t>
      ancestors;  ///< In the set that they were resampled from; may be empty.

  std::size_t size() const { return hypotheses.size(); }
  void Add(const Population& other);
};

/// How log-scale varies with a pose: the last row of the Cholesky factor of the covariance of both,
/// whose other rows are the factor of the pose's alone.
struct ScaleRow {
  Eigen::Vector4d with_pose = Eigen::Vector4d::Zero();
  double own = 0;  ///< On the diagonal; 0 where the scale is fixed.
};

/// Covariance about the modes of a population, pooled.
struct PoseSpread {
  Eigen::Matrix4d pose;             ///< (x, y, z in upright axes [m], azimuth [rad])
  Eigen::Vector4d scale_with_pose;  ///< Of log-scale,
  double scale_variance = 0;        ///< 0 where that is fixed.
};

/// One component of a proposal: a shape about a pose, with the heavy tails of Student's t.
struct ProposalMode {
  double weight = 0;  ///< Of all components together 1.
  PoseHypothesis mean;
  PoseHypothesis highest;  ///< Of the members that it was found by.
  Eigen::Matrix4d root;    ///< Lower Cholesky factor of the scale: (x, y, z in upright axes [m],
                           ///< azimuth [rad]).
  ScaleRow scale;
  double log_determinant = 0;  ///< Of the scale matrix, with log-scale where it is free.
};

/// Another shape about where a population stands.
struct ShapeRival {
  ModelId label;
  double log_ratio = 0;  ///< Of the target's mass there to that of the population's own shape.
};

/// Markov moves over shape, pose and (with `scale_std` > 0) scale that leave a target density
/// unchanged, whatever it is, and the search that tells them where to jump.
/// docs/algorithms/semantic_filter.md has the derivation.
class PoseSampler {
 public:
  /// `key` names all random numbers of this sampler.
  PoseSampler(const MapFrame& map, const MapperOptions& options, Target target, RandomKey key)
      : map_(map), options_(options), target_(std::move(target)), key_(key) {}

  std::vector<Judgement> Judge(std::span<const PoseHypothesis> hypotheses) const {
    return target_(hypotheses);
  }

  /// One Gaussian step for each hypothesis, with the spread of the population's modes, accepted by
  /// Metropolis' rule. Returns the share accepted.
  double Walk(Population& population);

  /// Where the density is high: the population's own modes, and those that a search from
  /// `challengers` finds, which are refined with falling temperature among themselves before they
  /// are compared.
  /// @param sharpness  Of the target (likelihood_sharpness.h). The search sees it as if it were 1,
  ///        or it would see the nearest slope alone; what it finds is then brought to its peak.
  std::vector<ProposalMode> FindModes(const Population& population,
                                      const std::vector<PoseHypothesis>& challengers,
                                      double sharpness = 1);

  /// One independent proposal for each hypothesis from the mixture of the modes, accepted by
  /// Metropolis' and Hastings' rule: jumps between modes and shapes in the proportions of the
  /// target. Returns the share accepted.
  double Jump(Population& population, const std::vector<ProposalMode>& modes);

  /// From equally weighted draws of anywhere to `count` of the target: temperatures such that each
  /// step keeps half of the effective sample size, with walks between (Del Moral, Doucet and Jasra,
  /// Sequential Monte Carlo samplers, 2006). The draws' own density is taken as flat.
  Population Temper(const std::vector<PoseHypothesis>& draws, std::size_t count);

  /// What the search starts from: `population` turned by half, quarter and any turns about axes
  /// inside the object, with other shapes, and a hand's breadth away; about `count` of them.
  std::vector<PoseHypothesis> Challengers(const std::vector<PoseHypothesis>& population,
                                          std::size_t count);

  /// How much less the target has of the other shapes of a category in a place: each is put where
  /// the population is, with its middle or a side in common, and the best start is brought to its
  /// peak. Masses are those of normal distributions about the peaks.
  /// @param population  Around one pose, of one shape.
  /// @param reach       Shapes that start lower than the population's best by more nats are left
  ///                    out.
  std::vector<ShapeRival> RivalShapes(const Population& population, double reach);

 private:
  /// @param room_step_m  Times LengthScale.
  PoseHypothesis Step(PoseHypothesis hypothesis, double room_step_m, double azimuth_rad);
  PoseHypothesis Turned(PoseHypothesis hypothesis);
  PoseHypothesis Relabelled(const PoseHypothesis& hypothesis);
  /// The same pose with another shape, which has its middle (0) or its low (1) or high (-1) side in
  /// the place of the first one's, in depth and width; what stands on the floor keeps its base.
  PoseHypothesis WithShape(PoseHypothesis hypothesis, ModelId label, double in_depth,
                           double in_width) const;
  /// Indices drawn in proportion to exp(log target / temperature), systematically.
  std::vector<std::size_t> Choose(const Population& population, double temperature,
                                  std::size_t count);
  double WalkAt(Population& population, double temperature);
  PoseHypothesis Draw(const std::vector<ProposalMode>& modes);
  double LogDensity(const std::vector<ProposalMode>& modes, const PoseHypothesis& hypothesis) const;
  /// Modes of a population, the highest first and none lower by more than `reach` [nats]; their
  /// spread is that of members that count exp(sharpness * log target), of few like `usual`.
  std::vector<ProposalMode> ModesOf(const Population& population, double sharpness, double reach,
                                    const PoseSpread& usual) const;
  PoseSpread SpreadWithin(const Population& population) const;
  bool Knows(const std::vector<ProposalMode>& modes, const ProposalMode& mode) const;
  /// The mode brought from a temperature down to the target, with its spread there.
  ProposalMode Polished(const ProposalMode& found, double temperature, const PoseSpread& usual);
  Eigen::Vector4d Difference(const PoseHypothesis& a, const PoseHypothesis& from) const;
  Random Next() {
    ++key_.particle;
    return Random(key_);
  }

  const MapFrame& map_;
  const MapperOptions& options_;
  Target target_;
  RandomKey key_;
};

}  // namespace plumbline
