// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/tracks_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "engine/dataset/stamped_rows.h"

namespace plumbline {

Result<FeatureTracks> ReadTracksFile(const std::filesystem::path& file) {
  FeatureTracks tracks;
  std::map<std::int64_t, std::vector<TrackedPoint>> by_stamp;
  auto warnings =
      ReadStampedRows(file, {"t,id,u,v", 3}, [&](std::int64_t stamp_ns, std::span<const double> v) {
        by_stamp[stamp_ns].push_back({std::llround(v[0]), {v[1], v[2]}});
      });
  if (!warnings.ok()) return warnings.error();
  tracks.warnings = std::move(warnings).value();
  for (auto& [stamp_ns, points] : by_stamp) tracks.images.push_back({stamp_ns, std::move(points)});
  if (tracks.images.empty()) {
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() + "' holds no usable track; it needs rows 't,id,u,v'"};
  }
  return tracks;
}

}  // namespace plumbline
