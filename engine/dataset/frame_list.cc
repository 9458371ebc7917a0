// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/frame_list.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <unordered_set>

#include "engine/base/files.h"
#include "engine/dataset/text_table.h"
#include "engine/dataset/tracks_file.h"
#include "engine/sensor/image_file.h"

namespace plumbline {
namespace {

Result<std::vector<std::string>> ImageNames(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (IsImageName(entry->path())) names.push_back(entry->path().filename().string());
  }
  if (error) {
    return Error{ErrorCode::kNotFound,
                 "cannot read the folder of images '" + folder.string() + "': " + error.message()};
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// Sorts by stamp and keeps the first of equal stamps.
void SortByStamp(const std::string& source, FrameList& list) {
  std::vector<FrameEntry>& frames = list.frames;
  const auto earlier = [](const FrameEntry& a, const FrameEntry& b) {
    return a.stamp_ns < b.stamp_ns;
  };
  std::stable_sort(frames.begin(), frames.end(), earlier);
  const auto same = [](const FrameEntry& a, const FrameEntry& b) {
    return a.stamp_ns == b.stamp_ns;
  };
  const std::size_t all = frames.size();
  const auto first = std::adjacent_find(frames.begin(), frames.end(), same);
  const std::string name = first != frames.end() ? std::next(first)->file : "";
  frames.erase(std::unique(frames.begin(), frames.end(), same), frames.end());
  if (frames.size() < all) {
    list.warnings.push_back("'" + source + "' has " + std::to_string(all - frames.size()) +
                            " frames with the stamp of another (such as '" + name +
                            "'); the first of each counts");
  }
}

Status FramesFromTable(const std::filesystem::path& table, FrameList& list) {
  const Result<std::string> text = ReadFile(table);
  if (!text.ok()) return text.error();
  LineWarnings warnings(table.string());
  std::unordered_set<std::string> seen;
  const std::vector<std::string_view> lines = SplitLines(text.value());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::vector<std::string_view> fields = SplitFields(lines[i]);
    if (fields.empty() || fields[0].starts_with('#') || (i == 0 && fields[0] == "stamp_s"))
      continue;
    const std::optional<std::int64_t> stamp = ParseStampNs(fields[0]);
    std::filesystem::path file = fields.size() == 2 ? fields[1] : "";
    if (file.parent_path() == "color") file = file.filename();
    if (!stamp || !IsImageName(file) || file.has_parent_path()) {
      warnings.Add(
          "not 'stamp_s,file' with a stamp in seconds and an image of color/; row left out", i + 1);
    } else if (!seen.insert(file.string()).second) {
      warnings.Add("the image has a row already; row left out", i + 1);
    } else {
      if (!list.frames.empty() && *stamp < list.frames.back().stamp_ns) {
        warnings.Add("the stamp is before the one above; rows sorted", i + 1);
      }
      list.frames.push_back({*stamp, file.string()});
    }
  }
  for (std::string& sentence : warnings.Sentences()) list.warnings.push_back(std::move(sentence));
  if (list.frames.empty()) {
    return Error{ErrorCode::kCorrupt,
                 "'" + table.string() + "' lists no frame; it needs rows 'stamp_s,file'"};
  }
  SortByStamp(table.string(), list);
  if (!list.has_images) return {};
  const Result<std::vector<std::string>> names = ImageNames(table.parent_path() / "color");
  if (!names.ok()) return names.error();
  const auto unlisted = [&](const std::string& name) { return !seen.contains(name); };
  const auto first = std::find_if(names->begin(), names->end(), unlisted);
  if (first != names->end()) {
    list.warnings.push_back("'" + table.string() + "' has no row for " +
                            std::to_string(std::count_if(first, names->end(), unlisted)) +
                            " images of color/ (such as '" + *first + "'); left out");
  }
  return {};
}

Status FramesFromNames(const std::filesystem::path& folder, double rate_hz, FrameList& list) {
  const Result<std::vector<std::string>> names = ImageNames(folder);
  if (!names.ok()) return names.error();
  std::string odd;
  for (const std::string& name : names.value()) {
    const std::string stem = std::filesystem::path(name).stem().string();
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
    const long double stamp = static_cast<long double>(number) / rate_hz * 1e9L;
    if (error != std::errc() || end != stem.data() + stem.size() || !(stamp < 9e18L)) {
      if (odd.empty()) odd = name;
      continue;
    }
    list.frames.push_back({static_cast<std::int64_t>(std::llround(stamp)), name});
  }
  if (list.frames.empty()) {
    return Error{ErrorCode::kNotFound,
                 "'" + folder.string() + "' holds no image named by a number (NNNNNN.jpg or .png)" +
                     (odd.empty() ? "" : "; give the stamps of '" + odd + "' in color.csv")};
  }
  if (!odd.empty()) {
    list.warnings.push_back("'" + folder.string() +
                            "' holds images whose names are no frame number (such as '" + odd +
                            "'); left out");
  }
  SortByStamp(folder.string(), list);
  return {};
}

Status FramesFromTracks(const std::filesystem::path& file, FrameList& list) {
  const Result<FeatureTracks> tracks = ReadTracksFile(file);
  if (!tracks.ok()) return tracks.error();
  list.warnings = tracks.value().warnings;
  for (const TrackedImage& image : tracks.value().images)
    list.frames.push_back({image.stamp_ns, ""});
  return {};
}

/// Frames per second of the median step.
std::optional<double> MedianRate(const std::vector<FrameEntry>& frames) {
  if (frames.size() < 2) return std::nullopt;
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < frames.size(); ++i)
    steps.push_back(frames[i].stamp_ns - frames[i - 1].stamp_ns);
  std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
  return 1e9 / static_cast<double>(steps[steps.size() / 2]);
}

}  // namespace

Result<FrameList> ListFrames(const std::filesystem::path& folder, std::optional<double> rate_hz) {
  FrameList list;
  const std::filesystem::path table = folder / "color.csv", tracks = folder / "tracks.csv";
  std::error_code ignored;
  const bool has_table = std::filesystem::exists(table, ignored);
  list.has_images = std::filesystem::exists(folder / "color", ignored);
  const bool from_tracks =
      !has_table && !list.has_images && std::filesystem::exists(tracks, ignored);
  if (!has_table && !list.has_images && !from_tracks) {
    return Error{ErrorCode::kNotFound, "'" + folder.string() +
                                           "' has neither images (color/) nor feature tracks "
                                           "(tracks.csv)"};
  }
  if (!has_table && !from_tracks && !rate_hz) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + (folder / "camera.json").string() +
                     "' has no 'rate_hz' and there is no color.csv: the frames have no time"};
  }
  const Status status = from_tracks ? FramesFromTracks(tracks, list)
                        : has_table ? FramesFromTable(table, list)
                                    : FramesFromNames(folder / "color", *rate_hz, list);
  if (!status.ok()) return status.error();
  if (!rate_hz) rate_hz = MedianRate(list.frames);
  if (!rate_hz) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + (folder / "camera.json").string() +
                     "' has no 'rate_hz' and there are too few frames to tell it"};
  }
  list.rate_hz = *rate_hz;
  return list;
}

}  // namespace plumbline
