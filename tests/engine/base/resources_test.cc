// SPDX-License-Identifier: Apache-2.0
#include "engine/base/resources.h"

#include <stdlib.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/base/files.h"
#include "tests/support/test_data.h"

void RegisterResources_base_test();  // made by plumbline_embed

namespace plumbline {
namespace {

constexpr const char* kName = "tests/engine/base/embedded_resource.txt";

TEST(Resources, AreTheFilesOfTheSourceTree) {
  RegisterResources_base_test();
  EXPECT_EQ(LoadResource(kName).value(), ReadFile(SourceDirectory() / kName).value());
}

TEST(Resources, NameTheOneThatIsMissing) {
  const Result<std::string> resource = LoadResource("shaders/none.frag");
  ASSERT_FALSE(resource.ok());
  EXPECT_EQ(resource.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(resource.error().message, testing::HasSubstr("shaders/none.frag"));
}

TEST(Resources, AreReadFromASourceTreeIfTheEnvironmentNamesOne) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "tests/engine/base");
  ASSERT_TRUE(WriteFileAtomically(folder.path() / kName, "edited").ok());
  setenv("PLUMBLINE_RESOURCES", folder.path().c_str(), 1);
  EXPECT_EQ(LoadResource(kName).value(), "edited");
  unsetenv("PLUMBLINE_RESOURCES");
}

}  // namespace
}  // namespace plumbline
