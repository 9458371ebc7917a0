// SPDX-License-Identifier: Apache-2.0
#include "engine/base/random_access_file.h"

#include <sys/stat.h>

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

TEST(RandomAccessFile, ReadsPiecesWhereverTheyLie) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "letters";
  ASSERT_TRUE(WriteFileAtomically(path, "abcdefgh").ok());
  auto opened = RandomAccessFile::Open(path);
  ASSERT_TRUE(opened.ok());
  RandomAccessFile file = std::move(opened).value();
  EXPECT_EQ(file.size(), 8u);
  EXPECT_EQ(file.Read(5, 3).value(), "fgh");
  EXPECT_EQ(file.Read(0, 2).value(), "ab");
  EXPECT_EQ(file.Read(8, 0).value(), "");
  for (const auto& [begin, count] :
       {std::pair<std::uint64_t, std::uint64_t>{7, 2}, {9, 0}, {1, UINT64_MAX}}) {
    const auto beyond = file.Read(begin, count);
    ASSERT_FALSE(beyond.ok());
    EXPECT_EQ(beyond.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(beyond.error().message, HasSubstr("letters"));
  }
  const RandomAccessFile moved = std::move(file);
  EXPECT_EQ(moved.Read(2, 1).value(), "c");
}

TEST(RandomAccessFile, RefusesWhatIsNoFileWithoutWaiting) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder.path() / "pipe").c_str(), 0600), 0);
  for (const char* name : {"pipe", ".", "nothing"}) {
    const auto opened = RandomAccessFile::Open(folder.path() / name);
    ASSERT_FALSE(opened.ok()) << name;
    EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
  }
}

}  // namespace
}  // namespace plumbline
