// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "engine/mapping/judging.h"

namespace plumbline {

/// What one frame in view shows of an object at its believed pose.
struct Sighting {
  double novelty = 0;           ///< How much of an independent look this frame is, in [0, 1].
  double visible_px = 0;        ///< Area of the box of its visible contour [px], where f = 500.
  double visible_fraction = 0;  ///< Of its contour, in [0, 1].
  double telling = 0;           ///< How much its contour can say, in [0, 1].
  double edge_fraction = 0;     ///< Of its contour, what shows and can speak for it alone.
  double inside_fraction = 1;   ///< Of its whole box, inside the image.
  float box_score = 0, box_iou = 0;  ///< Of the proposal matched with it; 0 without one.
  float edge_surplus = 0;  ///< Edge term beyond that of other places for the same contour nearby.
};

/// log p(sighting | there and not hidden) - log p(sighting | not there).
double SightingLogRatio(const Sighting& sighting, const MapperOptions& options);
/// The part of it that the box has, or that none was matched.
double BoxLogRatio(const Sighting& sighting, const MapperOptions& options);

/// What speaks for a tentative object. Its frames were judged as they passed, by poses that may
/// have been wrong, while its remembered views are judged by the pose that they have led to:
/// neither sum is a log ratio, and they share what they saw.
struct TentativeEvidence {
  double passing = 0;     ///< Log ratios of the frames as they passed, summed,
  double remembered = 0;  ///< those of its remembered views, for the pose of the last search,
  double boxes = 0;       ///< and what boxes have of the latter.
  bool shown = false;     ///< Enough of it has shown, at a pose that is believed (confirm_shown).
};

/// Log odds of a tentative object. Edges decide whether enough of it has shown; of what has, boxes
/// alone tell right from wrong.
double TentativeLogOdds(const TentativeEvidence& evidence, const MapperOptions& options);

/// What of its particles the mean pose of a tentative object must have to be confirmed, in [0, 1];
/// nothing while too little of it has shown. Where a belief has held for some looks, and what is
/// left of it is scattered, less will do.
/// @param shown  Independent looks in which enough of it showed at a pose that was believed.
/// @param visible_fraction  Of its contour, now.
/// @param rival  Whether a second mode has some of the belief.
std::optional<double> BeliefToConfirm(double shown, double visible_fraction, bool rival,
                                      const MapperOptions& options);

/// Two beliefs that go together: whether an object is there, and whether something that is not
/// mapped hides it. Being hidden begins seldom and ends seldom, so a wall costs little however long
/// it is looked at, while an empty place that shows costs much at once.
struct Existence {
  double log_odds = 0;  ///< Of being there.
  double hidden = 0;    ///< Probability of being hidden, if it is there.

  void Update(const Sighting& sighting, double dt_s, const MapperOptions& options);
  /// The same for what nothing unmapped is supposed to hide.
  void UpdateInView(const Sighting& sighting, const MapperOptions& options);
};

/// Edge term of the pose less the mean of the same contour at places around it: what the edges of
/// this neighbourhood give to anything of that shape. The edge term itself where too few of the
/// places are in view.
float EdgeSurplus(const HypothesisScorer& scorer, const ScoringView& view, const MapFrame& map,
                  const PoseHypothesis& pose);

}  // namespace plumbline
