// SPDX-License-Identifier: Apache-2.0
#include "engine/base/data_paths.h"

#include <gmock/gmock.h>

namespace plumbline {
namespace {

TEST(DataPaths, StayInTheirFolderUntilTheUserAllowsOtherwise) {
  for (const char* inside : {"a.ply", "meshes/a.ply", "./a.ply", "meshes/../a.ply", "..a.ply"}) {
    const auto place = PlaceInside("models", inside);
    ASSERT_TRUE(place.ok()) << inside;
    EXPECT_EQ(*place, std::filesystem::path("models") / inside);
  }
  for (const char* outside : {"../a.ply", "meshes/../../a.ply", "/etc/passwd", ".."}) {
    const auto place = PlaceInside("models", outside);
    ASSERT_FALSE(place.ok()) << outside;
    EXPECT_EQ(place.error().code, ErrorCode::kInvalidInput);
    EXPECT_THAT(place.error().message,
                testing::AllOf(testing::HasSubstr("'" + std::string(outside) + "'"),
                               testing::HasSubstr("--allow-outside")));
  }
  AllowOutside();  // of this process: last
  EXPECT_EQ(PlaceInside("models", "../a.ply").value(), std::filesystem::path("models/../a.ply"));
  EXPECT_EQ(PlaceInside("models", "/elsewhere/a.ply").value(),
            std::filesystem::path("/elsewhere/a.ply"));
}

TEST(DataPaths, AFileNameHasNoFolder) {
  for (const char* name : {"chair_0", "a.b", "chaise n° 1", "..a"}) EXPECT_TRUE(IsFileName(name));
  for (const char* name : {"", ".", "..", "a/b", "../a", "/a"}) EXPECT_FALSE(IsFileName(name));
  EXPECT_FALSE(IsFileName(std::string("a\0b", 3)));
}

}  // namespace
}  // namespace plumbline
