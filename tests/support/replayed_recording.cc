// SPDX-License-Identifier: Apache-2.0
#include "tests/support/replayed_recording.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <utility>
#include <vector>

#include "engine/base/files.h"
#include "engine/dataset/sequence.h"
#include "engine/dataset/text_table.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> RowsOf(const fs::path& file) {
  std::vector<std::string> rows;
  const std::string text = ReadFile(file).value();
  for (const std::string_view line : SplitLines(text)) {
    const auto fields = SplitFields(line);
    if (!fields.empty() && ParseStampNs(fields[0])) rows.emplace_back(line);
  }
  return rows;
}

/// Of color.csv or, without it, of the names in color/.
std::vector<std::string> ImageRowsOf(const fs::path& folder) {
  if (fs::exists(folder / "color.csv")) return RowsOf(folder / "color.csv");
  std::vector<std::string> rows;
  const auto sequence = OpenSequence(folder).value();
  std::vector<fs::path> names;
  for (const auto& entry : fs::directory_iterator(folder / "color"))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  for (int i = 0; i < sequence->num_frames(); ++i) {
    char row[80];
    std::snprintf(row, sizeof(row), "%.9f,color/%s",
                  1e-9 * static_cast<double>(sequence->stamp_ns(i)),
                  names[static_cast<std::size_t>(i)].c_str());
    rows.emplace_back(row);
  }
  return rows;
}

std::int64_t StampOf(const std::string& row) { return *ParseStampNs(SplitFields(row)[0]); }

void Append(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::app) << text;
}

}  // namespace

ReplayedRecording::ReplayedRecording(fs::path recorded, fs::path folder)
    : recorded_(std::move(recorded)), folder_(std::move(folder)) {
  fs::create_directories(folder_ / "color");
  lock_ = FileLock::Acquire(folder_ / "color.csv").value();
  for (const auto& entry : fs::directory_iterator(recorded_)) {
    const std::string name = entry.path().filename().string();
    if (name != "color" && name != "color.csv" && name != "imu.csv")
      fs::copy(entry.path(), folder_ / name, fs::copy_options::recursive);
  }
  image_rows_ = ImageRowsOf(recorded_);
  imu_rows_ = RowsOf(recorded_ / "imu.csv");
  Append(folder_ / "color.csv", "stamp_s,file\n");
  Append(folder_ / "imu.csv", "t,wx,wy,wz,ax,ay,az\n");
}

bool ReplayedRecording::Add(int images, double imu_ahead_ms) {
  for (; images > 0 && next_image_ < image_rows_.size(); --images, ++next_image_) {
    const std::string& row = image_rows_[next_image_];
    const auto until = StampOf(row) + static_cast<std::int64_t>(imu_ahead_ms * 1e6);
    std::string readings;
    for (; next_imu_ < imu_rows_.size() && StampOf(imu_rows_[next_imu_]) <= until; ++next_imu_)
      readings += imu_rows_[next_imu_] + "\n";
    Append(folder_ / "imu.csv", readings);
    const fs::path name = fs::path(SplitFields(row)[1]).filename();
    fs::copy_file(recorded_ / "color" / name, folder_ / "color" / name);
    Append(folder_ / "color.csv", row + "\n");
  }
  if (next_image_ < image_rows_.size()) return true;
  for (; next_imu_ < imu_rows_.size(); ++next_imu_)
    Append(folder_ / "imu.csv", imu_rows_[next_imu_] + "\n");
  return false;
}

}  // namespace plumbline
