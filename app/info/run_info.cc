// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "app/info/info_text.h"
#include "app/info/path_info.h"
#include "engine/recording/run_file.h"

namespace plumbline {
namespace {

void AddInputs(const RunHeader& header, PathInfo& info) {
  const RunRecipe& recipe = header.recipe;
  for (const auto& [label, path] :
       {std::pair<const char*, std::filesystem::path>{"Sequence", recipe.sequence},
        {"Models", recipe.models}}) {
    info.lines.push_back({label, path.string()});
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored))
      info.odd.push_back("'" + path.string() +
                         "' is not there any more; name it again when opening the run.");
  }
  info.lines.push_back({"Poses", ToText(recipe.poses)});
  info.lines.push_back({"Detector", ToText(recipe.detector.value_or(DetectorChoice()))});
  if (recipe.edges) info.lines.push_back({"Edges", ToText(*recipe.edges)});
}

/// Objects by their last state.
Status AddObjects(RunReader& reader, PathInfo& info) {
  const auto tracks = reader.ObjectTracks();
  if (!tracks.ok()) return tracks.error();
  int confirmed = 0, tentative = 0, retired = 0;
  for (const ObjectTrack& track : tracks.value()) {
    confirmed += track.state == ObjectState::kConfirmed;
    tentative += track.state == ObjectState::kTentative;
    retired += track.state == ObjectState::kRetired;
  }
  info.lines.push_back(
      {"Objects", Format("%d confirmed, %d tentative, %d retired", confirmed, tentative, retired)});
  info.json["objects"] = {{"confirmed", confirmed}, {"tentative", tentative}, {"retired", retired}};
  return {};
}

Status AddFrames(RunReader& reader, PathInfo& info) {
  const RunHeader& header = reader.header();
  const auto frames = reader.Frames();
  if (!frames.ok()) return frames.error();
  const auto timings = reader.Timings();
  if (!timings.ok()) return timings.error();
  std::size_t skipped = 0;
  for (const RunFrame& frame : frames.value()) skipped += frame.skipped;
  const double seconds = timings.value().empty() ? 0 : timings.value().back().elapsed_s;
  const std::size_t count = frames.value().size();
  info.lines.push_back(
      {"Frames", Format("%zu of %d:%d:%d, in %.1f s (%.1f frames/s)", count,
                        header.recipe.frames.begin, header.end_frame, header.recipe.frames.step,
                        seconds, seconds > 0 ? count / seconds : 0.0)});
  info.json["frames"] = {{"count", count},
                         {"skipped", skipped},
                         {"first", header.recipe.frames.begin},
                         {"end", header.end_frame},
                         {"step", header.recipe.frames.step},
                         {"seconds", seconds}};
  if (header.recipe.live_speed && count > 0) {
    // Up to the last that came; a run that was stopped has not seen the others.
    const int first = header.recipe.frames.begin, step = header.recipe.frames.step;
    const auto came = static_cast<std::size_t>((frames.value().back().frame - first) / step + 1);
    info.lines.push_back(
        {"Live", Format("%zu of %zu frames that came were taken, %zu passed over (speed %g)", count,
                        came, came - count, *header.recipe.live_speed)});
    info.json["live"] = {
        {"speed", *header.recipe.live_speed}, {"came", came}, {"passed_over", came - count}};
  }
  if (count == 0) info.odd.push_back("The run holds no frames.");
  if (skipped > 0) info.odd.push_back(Counted(skipped, "frame was", "frames were") + " skipped.");
  const auto finished = reader.Finished();
  if (!finished.ok()) return finished.error();
  info.json["finished"] = finished.value();
  if (!finished.value())
    info.odd.push_back(
        "The run is not finished: it is still being written, or can be continued with run "
        "--resume.");
  return {};
}

}  // namespace

Likeness ProbeRun(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return Likeness::kNone;
  char start[16] = {};
  std::ifstream(path, std::ios::binary).read(start, sizeof(start));
  const bool sqlite = std::string_view(start, 15) == "SQLite format 3";
  if (sqlite && HasEnding(path, ".plb")) return Likeness::kCertain;
  return sqlite || HasEnding(path, ".plb") ? Likeness::kPossible : Likeness::kNone;
}

Result<PathInfo> DescribeRun(const std::filesystem::path& path) {
  auto opened = RunReader::Open(path);
  if (!opened.ok()) return opened.error();
  RunReader& reader = **opened;
  const RunHeader& header = reader.header();
  PathInfo info;
  info.title = "run of the mapper, written by version " + header.program_version;
  if (const Status status = AddFrames(reader, info); !status.ok()) return status.error();
  if (const Status status = AddObjects(reader, info); !status.ok()) return status.error();
  AddInputs(header, info);
  info.lines.push_back({"Seed", std::to_string(header.recipe.seed)});
  info.lines.push_back({"Started", header.started});
  if (header.forked_after)
    info.lines.push_back({"Forked", "after frame " + std::to_string(*header.forked_after)});
  info.json["header"] = HeaderToJson(header);
  return info;
}

}  // namespace plumbline
