// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/recording_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/sequence_writing.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

int OpenToAppend(const fs::path& file) {
  return ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
}

Error CannotWrite(const fs::path& file) {
  return {ErrorCode::kIo, "cannot write '" + file.string() + "': " + std::strerror(errno) +
                              "; what was recorded until now is kept"};
}

}  // namespace

Result<std::unique_ptr<RecordingWriter>> RecordingWriter::Create(
    const fs::path& folder, const nlohmann::json& camera,
    const std::optional<nlohmann::json>& imu) {
  std::error_code error;
  if (fs::exists(folder, error) &&
      !(fs::is_directory(folder, error) && fs::is_empty(folder, error)))
    return Error{ErrorCode::kInvalidInput,
                 "'" + folder.string() + "' is there already; record into a new folder"};
  fs::create_directories(folder / "color", error);
  if (error)
    return Error{ErrorCode::kIo,
                 "cannot make the folder '" + folder.string() + "': " + error.message()};
  auto lock = FileLock::Acquire(folder / "color.csv");
  if (!lock.ok()) return lock.error();
  std::unique_ptr<RecordingWriter> writer(new RecordingWriter(folder, std::move(lock).value()));
  Status status = WriteJson(folder / "camera.json", camera);
  if (status.ok() && imu) status = WriteJson(folder / "imu.json", *imu);
  if (status.ok()) status = writer->OpenTables();
  if (!status.ok()) return status.error();
  status = writer->Append(writer->readings_, "imu.csv", "t,wx,wy,wz,ax,ay,az\n");
  if (status.ok()) status = writer->Append(writer->images_, "color.csv", "stamp_s,file\n");
  if (!status.ok()) return status.error();
  return writer;
}

Result<std::unique_ptr<RecordingWriter>> RecordingWriter::Join(const fs::path& folder) {
  std::unique_ptr<RecordingWriter> writer(new RecordingWriter(folder, nullptr));
  for (const char* name : {"imu.csv", "color.csv"}) {
    const Result<std::string> text = ReadFile(folder / name);
    if (!text.ok()) return text.error();
    const auto lines = static_cast<int>(std::count(text->begin(), text->end(), '\n'));
    // Of a row that was being written when its writer was killed nothing is known.
    const bool torn = !text->empty() && text->back() != '\n';
    if (std::string_view(name) == "color.csv")
      writer->num_images_ = lines - 1 + (torn ? 1 : 0);
    else
      writer->joined_readings_ = lines > 1;
    const int table = torn ? OpenToAppend(folder / name) : -1;
    if (table < 0) continue;
    const Status ended = writer->Append(table, name, "\n");
    ::close(table);
    if (!ended.ok()) return ended.error();
  }
  if (Status status = writer->OpenTables(); !status.ok()) return status.error();
  return writer;
}

void RecordingWriter::RemoveIfEmpty(const fs::path& folder) {
  for (const char* name : {"imu.csv", "color.csv"}) {
    const Result<std::string> text = ReadFile(folder / name);
    if (!text.ok() || std::count(text->begin(), text->end(), '\n') > 1) return;
  }
  std::error_code ignored;
  for (const char* name : {"camera.json", "imu.json", "imu.csv", "color.csv", "color", ""})
    fs::remove(folder / name, ignored);
}

Status RecordingWriter::OpenTables() {
  readings_ = OpenToAppend(folder_ / "imu.csv");
  images_ = OpenToAppend(folder_ / "color.csv");
  if (readings_ < 0 || images_ < 0) return CannotWrite(folder_ / "color.csv");
  return {};
}

RecordingWriter::~RecordingWriter() {
  if (images_ >= 0) ::close(images_);
  if (readings_ >= 0) ::close(readings_);
}

Status RecordingWriter::Append(int descriptor, const char* name, std::string_view rows) const {
  while (!rows.empty()) {
    const ssize_t written = ::write(descriptor, rows.data(), rows.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return CannotWrite(folder_ / name);
    rows.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

Status RecordingWriter::AddReadings(std::span<const ImuSample> samples) {
  std::string rows;
  for (const ImuSample& sample : samples) {
    const Eigen::Vector3d &w = sample.angular_velocity_rad_s, &a = sample.specific_force_m_s2;
    char numbers[200];
    std::snprintf(numbers, sizeof(numbers), ",%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", w.x(), w.y(), w.z(),
                  a.x(), a.y(), a.z());
    rows += StampText(sample.stamp_ns) + numbers;
  }
  return Append(readings_, "imu.csv", rows);
}

Status RecordingWriter::AddImage(std::int64_t stamp_ns, std::string_view encoded,
                                 std::string_view ending) {
  char number[16];
  std::snprintf(number, sizeof(number), "%06d", num_images_.load());
  const std::string name = number + std::string(ending);
  const fs::path file = folder_ / "color" / name, part = file.string() + ".part";
  {
    std::ofstream stream(part, std::ios::binary);
    stream.write(encoded.data(), static_cast<std::streamsize>(encoded.size()));
    stream.flush();
    if (!stream) return CannotWrite(part);
  }
  std::error_code error;
  fs::rename(part, file, error);
  if (error) return CannotWrite(file);
  ++num_images_;
  return Append(images_, "color.csv", StampText(stamp_ns) + ",color/" + name + "\n");
}

}  // namespace plumbline
