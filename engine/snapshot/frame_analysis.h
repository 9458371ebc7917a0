// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/snapshot/object_relation.h"

namespace plumbline {

struct MapSnapshot;

/// Edges of the frame by another detector than the run's.
struct OtherEdges {
  std::string choice;          ///< As --edges names it.
  cv::Mat probability, angle;  ///< CV_8U (see EdgeMap); empty if `problem` says why.
  std::string problem;
};

/// Top-down: what the run's detector scores for a box of one size, moved over the image.
struct ScoreMap {
  std::string category;
  double width_px = 0, height_px = 0;  ///< Of the box: that of the object's visible part.
  int step_px = 1;
  cv::Mat scores;  ///< CV_32FC1: at (row, column) for the box centred on (column, row) * step_px.
  std::string problem;
};

/// How far the belief about an object spreads over all of its modes.
struct ObjectSpread {
  ObjectId object;
  int modes = 0;
  double position_std_m = 0;              ///< Root of the sum over three axes.
  std::optional<double> azimuth_std_rad;  ///< Nothing for a round shape.
};

/// What is worked out of a frame besides what the mapper says, where somebody shows it.
struct FrameAnalysis {
  std::shared_ptr<const MapSnapshot> frame;  ///< Never null.
  /// How its objects stand to one another; nothing: nobody asked.
  std::optional<std::vector<ObjectRelation>> relations;
  std::vector<ObjectSpread> spreads;      ///< Of every object.
  ObjectId object;                        ///< The one that is watched.
  std::vector<int> by_rank;               ///< Indices of its particles, the best first.
  std::optional<OtherEdges> other_edges;  ///< Nothing: nobody asked.
  std::optional<ScoreMap> score_map;
};

}  // namespace plumbline
