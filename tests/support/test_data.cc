// SPDX-License-Identifier: Apache-2.0
#include "tests/support/test_data.h"

#include <stdlib.h>

#include <stdexcept>
#include <string>

namespace plumbline {
namespace {
std::filesystem::path FromEnvironment(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr)
    throw std::runtime_error(std::string(name) + " is not set; run the tests through ctest");
  return value;
}
}  // namespace

std::filesystem::path SourceDirectory() { return FromEnvironment("PLUMBLINE_SOURCE_DIR"); }
std::filesystem::path ProgramFile() { return FromEnvironment("PLUMBLINE_BINARY"); }

std::optional<std::filesystem::path> SharedData() {
  std::filesystem::path root;
  if (const char* data = std::getenv("PLUMBLINE_DATA"); data != nullptr) {
    root = data;
  } else {
    root = SourceDirectory().parent_path() / "shared";
  }
  if (!std::filesystem::exists(root / "data")) return std::nullopt;
  return root;
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "plumbline_test_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make a temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace plumbline
