// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/smoothed_table.h"

#include <cmath>
#include <cstdio>

#include "engine/geometry/angles.h"
#include "engine/models/model_database.h"
#include "engine/smoothing/smoothed_map_report.h"

namespace plumbline {

void PrintSmoothed(const SmoothedMap& map, const ModelDatabase& database) {
  std::printf("\nsmoothed, over all frames\n%6s  %-16s %-14s %-10s %9s  %-24s %8s %8s %6s %6s\n",
              "object", "model", "category", "found", "seen from", "position [m]", "std [cm]",
              "[deg]", "views", "agree");
  for (const SmoothedObject& object : map.objects) {
    const ObjectReport& belief = object.belief;
    if (belief.state != ObjectState::kConfirmed) continue;
    const Eigen::Vector3d t = belief.world_from_object.translation();
    const char* found = belief.confirmed_frame ? "in the run" : "only now";
    std::printf("%6d  %-16s %-14s %-10s %9d  %7.3f %7.3f %7.3f  %8.1f %8.1f %6d %6.2f\n",
                belief.id.value, database.model(belief.label).name.c_str(), belief.category.c_str(),
                found, belief.first_frame, t.x(), t.y(), t.z(),
                100 * std::sqrt(belief.covariance.topLeftCorner<3, 3>().trace()),
                std::sqrt(belief.covariance(3, 3)) / kRadPerDeg, object.views, object.agreement);
  }
  if (map.floor_objects > 0) {
    std::printf("%d objects share a floor %+.1f cm (std %.1f cm) from the one given\n",
                map.floor_objects, 100 * map.floor_height_m, 100 * map.floor_std_m);
  }
}

Error NotSmoothed(const Error& error, const std::string& run) {
  return {error.code,
          error.message + "; '" + run + "' keeps the run, and 'plumbline smooth' smooths it later"};
}

}  // namespace plumbline
