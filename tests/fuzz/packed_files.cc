// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/packed_files.h"

#include <algorithm>
#include <cctype>

namespace plumbline::fuzz {
namespace {

constexpr std::string_view kBegin = "==> ", kEnd = " <==\n";

bool StaysInside(std::string_view name) {
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '.' || c == '_' || c == '-' || c == '/';
  });
  return plain && !name.empty() && name.size() < 100 && name.front() != '/' && name.back() != '/' &&
         name.find("..") == std::string_view::npos;
}

/// Where the next line begins that names a file; the end without one.
std::size_t NextName(std::string_view input, std::size_t from) {
  while (from < input.size()) {
    if (input.substr(from).starts_with(kBegin)) {
      const std::size_t end = input.find('\n', from);
      if (end != std::string_view::npos && input.substr(from, end + 1 - from).ends_with(kEnd))
        return from;
    }
    const std::size_t line = input.find('\n', from);
    from = line == std::string_view::npos ? input.size() : line + 1;
  }
  return input.size();
}

}  // namespace

std::vector<PackedFile> SplitFiles(std::string_view input) {
  std::vector<PackedFile> files;
  for (std::size_t at = NextName(input, 0); at < input.size();) {
    const std::size_t content = input.find('\n', at) + 1;
    const std::size_t next = NextName(input, content);
    const std::string_view name =
        input.substr(at + kBegin.size(), content - at - kBegin.size() - kEnd.size());
    if (StaysInside(name))
      files.push_back({std::string(name), std::string(input.substr(content, next - content))});
    at = next;
  }
  return files;
}

std::string JoinFiles(const std::vector<PackedFile>& files) {
  std::string joined;
  for (const PackedFile& file : files) {
    if (!joined.empty() && joined.back() != '\n') joined += '\n';
    joined.append(kBegin).append(file.name).append(kEnd).append(file.content);
  }
  return joined;
}

}  // namespace plumbline::fuzz
