// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "app/info/info_text.h"
#include "app/info/path_info.h"
#include "engine/dataset/stamp_statistics.h"
#include "engine/dataset/text_table.h"
#include "engine/dataset/trajectory.h"

namespace plumbline {

Likeness ProbeTrajectory(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return Likeness::kNone;
  std::ifstream file(path);
  constexpr int kLinesLookedAt = 20;
  char line[512];
  for (int i = 0; i < kLinesLookedAt && file.getline(line, sizeof(line)); ++i) {
    const std::vector<std::string_view> fields = SplitFields(line);
    if (fields.empty() || fields[0].starts_with('#')) continue;
    for (const std::string_view field : fields) {
      if (!ParseNumber(field.substr(0, field.find('\r')))) return Likeness::kNone;
    }
    return fields.size() == 8 ? Likeness::kPossible : Likeness::kNone;
  }
  return Likeness::kNone;
}

Result<PathInfo> DescribeTrajectory(const std::filesystem::path& path) {
  const Result<Trajectory> read = ReadTrajectory(path, Eigen::Isometry3d::Identity());
  if (!read.ok()) return read.error();
  const std::vector<StampedPose>& poses = read.value().poses;
  std::ifstream file(path);
  std::string first;
  std::getline(file, first);
  const bool of_body = first.starts_with('#') && first.find("world_from_body") != std::string::npos;
  std::vector<std::int64_t> stamps;
  double length = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    stamps.push_back(poses[i].stamp_ns);
    if (i == 0) continue;
    length +=
        (poses[i].world_from_cam.translation() - poses[i - 1].world_from_cam.translation()).norm();
  }
  const StampStatistics statistics = StatisticsOf(stamps, 1.5);
  PathInfo info;
  info.title = std::string("trajectory (TUM) of the ") + (of_body ? "body" : "camera");
  info.lines = {{"Poses", Format("%zu at %.4g Hz, %.1f s", poses.size(), statistics.rate_hz(),
                                 statistics.span_s())},
                {"Path", Format("%.1f m", length)}};
  info.json["poses"] = poses.size();
  info.json["rate_hz"] = statistics.rate_hz();
  info.json["span_s"] = statistics.span_s();
  info.json["path_m"] = length;
  info.json["of_body"] = of_body;
  info.odd = read.value().warnings;
  if (statistics.gaps > 0) {
    info.odd.push_back(
        Format("%d gaps: the longest lasts %.2f s.", statistics.gaps, statistics.longest_step_s));
  }
  return info;
}

}  // namespace plumbline
