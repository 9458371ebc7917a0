// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/tracks_file.h"

#include <gmock/gmock.h>

#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

TEST(TracksFile, GathersThePointsOfEachImageInOrderOfTime) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "tracks.csv";
  WriteText(file, "#t,id,u,v\n0.2,5,10.5,20\n0.1,5,10,19.5\n0.2,6,1,2\n0.2,7,1\n");
  const auto tracks = ReadTracksFile(file);
  ASSERT_TRUE(tracks.ok()) << tracks.error().message;
  ASSERT_EQ(tracks->images.size(), 2u);
  EXPECT_EQ(tracks->images[0].stamp_ns, 100000000);
  EXPECT_EQ(tracks->images[1].points.size(), 2u);
  EXPECT_EQ(tracks->images[1].points[0].id, 5);
  EXPECT_EQ(tracks->images[1].points[0].pixel, Eigen::Vector2d(10.5, 20));
  EXPECT_THAT(tracks->warnings,
              testing::ElementsAre(testing::HasSubstr("line 5: not a row 't,id,u,v'")));
  WriteText(file, "#t,id,u,v\n");
  EXPECT_EQ(ReadTracksFile(file).error().code, ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace plumbline
