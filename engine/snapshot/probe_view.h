// SPDX-License-Identifier: Apache-2.0
#pragma once

// One object of one frame under the magnifying glass: how hypotheses score, and why.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/ids.h"
#include "engine/geometry/box.h"

namespace plumbline {

/// One sample of a hypothesis' contour in the image.
struct ContourSample {
  Eigen::Vector2f pixel;
  Eigen::Vector2f normal;           ///< Unit vector: the search goes along it, both ways.
  bool visible = false;             ///< False: behind another object.
  float hit = 0;                    ///< What the search table gives here, in [0, 1].
  std::optional<float> edge_at_px;  ///< Along the normal: the edge that gives the hit.
};

/// A hypothesis, and what it scores in the frame, by the mapper's own rule.
struct ProbedHypothesis {
  std::string name;  ///< "mean", "best particle", "truth table_0" ...
  std::optional<int> particle;
  bool is_truth = false;
  ModelId label;
  Eigen::Vector3d center_in_world{0, 0, 0};
  double azimuth_rad = 0;
  double log_scale = 0;
  float phi_cnn = 0, phi_edge = 0;
  std::optional<float> phi_edge_rendered;  ///< By the reference scorer.
  float score = 0;                         ///< alpha Phi_cnn + beta Phi_edge
  float visible_fraction = 0;
  Box2 whole_box, visible_box;
  std::optional<float> from_truth_m, from_truth_rad;  ///< Of centre and azimuth.
  std::vector<ContourSample> samples;
  std::vector<std::vector<Eigen::Vector2f>> outline;  ///< Of its whole projection [px], closed.
};

/// The score along one parameter, the others as in the mean.
struct LikelihoodSlice {
  std::string parameter, unit;  ///< "distance", "cm"
  std::vector<float> offsets;   ///< From the mean, in `unit`.
  std::vector<float> phi_cnn, phi_edge, score;
  std::vector<float> phi_edge_rendered;  ///< As long as offsets, or empty.
  std::optional<float> truth;            ///< Offset of the true place.
};

/// The score over two parameters at once, the others as in the mean. Values row by row, `y` rising.
struct LikelihoodMap {
  std::string x_parameter, x_unit, y_parameter, y_unit;
  std::vector<float> x_offsets, y_offsets;  ///< From the mean.
  std::vector<float> phi_cnn, phi_edge, score;
  std::optional<Eigen::Vector2f> truth;  ///< Offset of the true place.
};

/// What keeps an object from being where it should be.
enum class Verdict {
  kNoTruth,     ///< There is nothing to compare with.
  kRight,       ///< Nothing: it is there.
  kSpurious,    ///< There is no such object.
  kSecond,      ///< Another object already explains the only true one nearby.
  kLikelihood,  ///< The wrong place scores better in this frame.
  kSearch,      ///< The truth would score better, but no particle is near it.
  kTime         ///< Particles are near the truth; the weights have not followed yet.
};

struct ProbeView {
  int frame = -1;
  ObjectId object;
  std::string truth;  ///< That was asked for instead of an object; "": an object was.
  double alpha = 0, beta = 0;
  float search_radius_px = 0;
  float chance = 0;                          ///< Hit that a contour gets by chance.
  std::string message;                       ///< Why there is nothing; "" else.
  std::optional<Verdict> verdict;            ///< Nothing where there is a message.
  std::string verdict_text;                  ///< The same as a sentence, with figures.
  std::vector<ProbedHypothesis> hypotheses;  ///< The first is the mean.
  int hovered = -1;  ///< The particle under the mouse, if one was asked for.
  std::vector<std::vector<Eigen::Vector2f>> hovered_outline;
  std::vector<LikelihoodSlice> slices;
  std::vector<LikelihoodMap> maps;  ///< Only where they were asked for.
  float nearest_particle_m =
      -1;  ///< Of the particles' centres from the true one; < 0 without truth.
};

}  // namespace plumbline
