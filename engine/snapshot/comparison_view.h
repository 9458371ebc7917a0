// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace plumbline {

struct MapSnapshot;
struct ObjectReport;

/// An object of one run and what is the same in another; one of them may be missing.
struct ObjectPair {
  const ObjectReport* a = nullptr;
  const ObjectReport* b = nullptr;
  double distance_m = 0, azimuth_rad = 0;  ///< Between their poses; 0 where one is missing.
};

struct StageDifference {
  std::string stage;
  double mean_a_ms = 0,
         mean_b_ms = 0;  ///< Over the frames of each run; 0 where it lacks the stage.
};

/// What tells two runs of a sequence apart, in a frame and as a whole.
struct ComparisonView {
  std::shared_ptr<const MapSnapshot> a, b;  ///< The frames; `pairs` points into them.
  std::vector<ObjectPair> pairs;            ///< Their confirmed objects.
  std::vector<std::string> settings;        ///< What differs: "alpha: 2.5 / 4".
  std::optional<int> first_difference;      ///< The first common frame in which beliefs differ.
  std::vector<StageDifference> stages;
};

}  // namespace plumbline
