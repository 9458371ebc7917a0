// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the authors' filter does to the belief about one object (docs/algorithms/paper_filter.md).

#include <span>
#include <vector>

#include "engine/mapping/bytes.h"
#include "engine/mapping/nearest_edges.h"
#include "engine/mapping/particle_set.h"
#include "engine/vision/detector.h"

namespace plumbline {

/// What it keeps of an object besides the particles.
struct PaperTrack {
  int updates = 0;              ///< Since it was last without a settled pose.
  int settled_updates = 0;      ///< With one.
  int matched = 0;              ///< Frames in view with a box of it,
  int unmatched = 0;            ///< and without.
  int same_label = 0;           ///< Updates for which the most likely label has not changed.
  std::vector<Particle> means;  ///< The last ones, the newest last; weights and scores unused.

  /// Takes up the mean after an update.
  void Add(const Particle& mean, bool settled);
  /// Begins again; frames with and without a box stay counted.
  void Unsettle();
  void Save(ByteWriter& out) const;
  void Restore(ByteReader& in);
};

/// Equally weighted particles of a newborn object: the same poses for each of `labels`.
/// @param key  Without a particle.
std::vector<Particle> BirthAsPaper(const Box2& box, const PinholeCamera& camera,
                                   std::span<const ModelId> labels, const PaperOptions& options,
                                   RandomKey key);

/// One image in which particles are updated, level by level.
struct PaperImage {
  const HypothesisScorer* scorer = nullptr;
  const MapFrame* map = nullptr;
  ScoringView view;                      ///< At full size; its table is not read.
  std::span<const NearestEdges> levels;  ///< The coarsest first.
  const FrameDetections* detections = nullptr;
};

/// ln of the detector's score of each box, from that of the least score on.
/// @param detections  May be null.
std::vector<float> LogScores(const FrameDetections* detections, const std::string& category,
                             std::span<const Box2> boxes);

struct PaperUpdate {
  std::size_t count = 0;        ///< Particles afterwards.
  bool settled = false;         ///< Which of the two diffusions.
  RandomKey diffuse, resample;  ///< Without particles.
};

/// Diffuses, weighs and resamples particles on every level. Their weights are equal afterwards;
/// phi_edge is the edge score E and phi_cnn the logarithm of the detector's score.
void UpdateAsPaper(std::vector<Particle>& particles,
                   const Eigen::Isometry3d& world_from_reference_cam, const PaperImage& image,
                   const PaperOptions& options, const PaperUpdate& update);

/// Whether an object's pose has settled.
/// @param match   Of its mean, at full size.
/// @param model   Of its most likely label.
bool Settles(const PaperTrack& track, const EdgeMatch& match, const CadModel& model);
/// Whether a settled one is lost again.
bool Lost(const EdgeMatch& match);
/// Whether its time without a settled pose, or without a box, is over.
bool TooManyUpdates(const PaperTrack& track, const PaperOptions& options);
bool TooFewBoxes(const PaperTrack& track, const PaperOptions& options);

}  // namespace plumbline
