// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/mapping/bytes.h"
#include "engine/mapping/judging.h"

namespace plumbline {

/// How the log-likelihood of one view changes as an object moves across its image: sums over both
/// directions, per square of a step of one pixel at a focal length of 500.
struct ViewSlope {
  double squared_slope = 0;
  double curvature = 0;  ///< Minus the second derivative: positive at a peak.
};
/// Of the edge term of a whole view at a pose, by central differences.
ViewSlope SlopeOf(const HypothesisScorer& scorer, const JudgingView& view, const MapFrame& map,
                  const PoseHypothesis& pose, const MapperOptions& options);

/// How sharply the likelihood of views may be taken. Of a true likelihood the
/// variance of the slope at the truth equals the mean curvature (Bartlett's second identity). Edges
/// in a picture are no such thing: their errors depend on camera, pictures, models and poses. The
/// ratio of the two, measured at objects that have settled, is the exponent that gives an estimate
/// the spread that it has (magnitude adjustment of a composite likelihood: Pauli, Racugno and
/// Ventura, Statistica Sinica 21, 2011; Ribatet, Cooley and Davison, Statistica Sinica 22, 2012).
class LikelihoodSharpness {
 public:
  /// A view of an object whose pose other views have settled; `looks`: how independent it is of the
  /// views before it.
  void Add(const ViewSlope& slope, double looks) {
    looks_ += looks;
    squared_slope_ += looks * slope.squared_slope;
    curvature_ += looks * slope.curvature;
  }
  /// The exponent of one object, which is taken for one of its sequence until it has been looked at
  /// itself; 1 where nothing is known of either.
  double ValueWithin(const LikelihoodSharpness& sequence) const;

  void Save(ByteWriter& out) const {
    out.Put(looks_);
    out.Put(squared_slope_);
    out.Put(curvature_);
  }
  void Restore(ByteReader& in) {
    looks_ = in.Get<double>();
    squared_slope_ = in.Get<double>();
    curvature_ = in.Get<double>();
  }

 private:
  double looks_ = 0, squared_slope_ = 0, curvature_ = 0;
};

}  // namespace plumbline
