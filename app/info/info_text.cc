// SPDX-License-Identifier: Apache-2.0
#include "app/info/info_text.h"

#include <strings.h>

#include <cstdarg>
#include <cstdio>

namespace plumbline {

std::string Format(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof(text), format, arguments);
  va_end(arguments);
  return text;
}

std::string Counted(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string SizeText(const Eigen::Vector3d& size_m) {
  return Format("%.2f x %.2f x %.2f m", size_m.x(), size_m.y(), size_m.z());
}

std::string BytesText(std::uintmax_t bytes) {
  const char* const kUnits[] = {"bytes", "kB", "MB", "GB", "TB"};
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; value >= 1000 && unit + 1 < std::size(kUnits); ++unit) value /= 1000;
  return Format(unit == 0 || value >= 100 ? "%.0f %s" : "%.1f %s", value, kUnits[unit]);
}

std::uintmax_t BytesOnDisk(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) {
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    return error ? 0 : size;
  }
  std::uintmax_t total = 0;
  for (std::filesystem::recursive_directory_iterator entry(path, error), end;
       !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    if (!entry->is_regular_file(ignored)) continue;
    const std::uintmax_t size = entry->file_size(ignored);
    if (!ignored) total += size;
  }
  return total;
}

bool HasEnding(const std::filesystem::path& file, const char* ending) {
  return strcasecmp(file.extension().c_str(), ending) == 0;
}

}  // namespace plumbline
