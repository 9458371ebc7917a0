// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/curve_keys.h"

#include <filesystem>

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

TEST(CurveKeys, AreReadBackWithThoseOfTheOthers) {
  const TemporaryFolder folder;
  ASSERT_TRUE(MakeCurveKeys(folder.path(), "player").ok());
  ASSERT_TRUE(MakeCurveKeys(folder.path(), "mapper").ok());
  std::filesystem::remove(folder.path() / "mapper.secret");  // as on the player's machine
  const auto keys = ReadCurveKeys(folder.path(), "player");
  ASSERT_TRUE(keys.ok()) << keys.error().message;
  EXPECT_EQ(keys->public_of.size(), 2u);
  EXPECT_EQ(keys->public_of.at("player"), keys->own_public);
  EXPECT_NE(keys->own_public, keys->own_secret);
  const auto missing = ReadCurveKeys(folder.path(), "mapper");
  ASSERT_FALSE(missing.ok());
  EXPECT_THAT(missing.error().message, testing::HasSubstr("plumbline keys mapper"));
}

TEST(CurveKeys, AreNeverReplacedAndNeverReadableByOthers) {
  const TemporaryFolder folder;
  ASSERT_TRUE(MakeCurveKeys(folder.path(), "player").ok());
  EXPECT_FALSE(MakeCurveKeys(folder.path(), "player").ok());
  EXPECT_FALSE(MakeCurveKeys(folder.path(), "../player").ok());
  namespace fs = std::filesystem;
  const fs::path secret = folder.path() / "player.secret";
  EXPECT_EQ(fs::status(secret).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  fs::permissions(secret, fs::perms::group_read, fs::perm_options::add);
  const auto keys = ReadCurveKeys(folder.path(), "player");
  ASSERT_FALSE(keys.ok());
  EXPECT_THAT(keys.error().message, testing::HasSubstr("chmod 600"));
}

TEST(CurveKeys, RefuseWhatIsNoKey) {
  const TemporaryFolder folder;
  ASSERT_TRUE(MakeCurveKeys(folder.path(), "player").ok());
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "other.public", "no key\n").ok());
  const auto keys = ReadCurveKeys(folder.path(), "player");
  ASSERT_FALSE(keys.ok());
  EXPECT_EQ(keys.error().code, ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace plumbline
