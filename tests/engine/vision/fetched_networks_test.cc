// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/fetched_networks.h"

#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/vision/network_sidecar.h"
#include "tests/support/local_server.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

class Fetching : public testing::Test {
 protected:
  Fetching() {
    for (int i = 0; i < 40000; ++i) content_ += std::to_string(i * i);
    WriteText(folder_.path() / "truth", content_);
    network_.name = "net";
    network_.sha256 = Sha256OfFile(folder_.path() / "truth").value();
    network_.bytes = content_.size();
    network_.sidecar = "{}";
  }
  Result<std::filesystem::path> FetchFrom(const LocalServer& server) {
    network_.url = server.url();
    return FetchNetwork(network_, folder_.path(), {});
  }
  bool Exists(const char* file) const { return std::filesystem::exists(folder_.path() / file); }

  TemporaryFolder folder_;
  std::string content_;
  ListedNetwork network_;
};

TEST_F(Fetching, GivesTheFileItsNameAndASidecar) {
  const LocalServer server(content_);
  const auto file = FetchFrom(server);
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_EQ(ReadFile(*file).value(), content_);
  EXPECT_TRUE(Exists("net.json"));
  EXPECT_FALSE(Exists("net.onnx.part"));
  // Again: nothing is downloaded.
  EXPECT_TRUE(FetchFrom(server).ok());
  EXPECT_EQ(server.bytes_sent(), content_.size());
}

TEST_F(Fetching, GoesOnWhereItWasCutOff) {
  const std::size_t piece = content_.size() / 4 + 1;
  const LocalServer server(content_, {.cut_after = piece});
  int tries = 0;
  while (!Exists("net.onnx") && tries < 10) {
    const auto file = FetchFrom(server);
    ++tries;
    if (!file.ok()) {
      EXPECT_EQ(file.error().code, ErrorCode::kIo);
      EXPECT_THAT(file.error().message, HasSubstr("again"));
    }
  }
  EXPECT_EQ(tries, 4);
  EXPECT_EQ(server.bytes_sent(), content_.size());
  EXPECT_EQ(ReadFile(folder_.path() / "net.onnx").value(), content_);
}

TEST_F(Fetching, BeginsAnewWhereTheServerKnowsNoRanges) {
  WriteText(folder_.path() / "net.onnx.part", content_.substr(0, 1000));
  const LocalServer server(content_, {.knows_ranges = false});
  const auto file = FetchFrom(server);
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_EQ(ReadFile(*file).value(), content_);
}

TEST_F(Fetching, KeepsNothingOfAnotherContent) {
  std::string other = content_;
  other[1234] = '!';
  for (const std::string& wrong : {other, content_ + "more", content_.substr(5)}) {
    const LocalServer server(wrong);
    const auto file = FetchFrom(server);
    ASSERT_FALSE(file.ok());
    EXPECT_EQ(file.error().code, ErrorCode::kCorrupt) << file.error().message;
    EXPECT_FALSE(Exists("net.onnx"));
    EXPECT_FALSE(Exists("net.onnx.part"));
  }
}

TEST_F(Fetching, DoesNotTrustWhatAnEarlierTryLeft) {
  WriteText(folder_.path() / "net.onnx.part", std::string(content_.size(), 'x'));
  const LocalServer server(content_);
  EXPECT_TRUE(FetchFrom(server).ok());
  WriteText(folder_.path() / "net.onnx", "broken since");
  EXPECT_TRUE(FetchFrom(server).ok());
  EXPECT_EQ(ReadFile(folder_.path() / "net.onnx").value(), content_);
}

TEST_F(Fetching, SaysWhatIsWrong) {
  const LocalServer gone(content_, {.status = 404});
  const auto missing = FetchFrom(gone);
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, HasSubstr("404"));
  network_.url = "http://127.0.0.1:9/net.onnx";  // nobody listens there
  const auto offline = FetchNetwork(network_, folder_.path(), {});
  ASSERT_FALSE(offline.ok());
  EXPECT_EQ(offline.error().code, ErrorCode::kIo);
  EXPECT_THAT(offline.error().message, HasSubstr("cannot reach"));
  network_.url = "http://example.org/net.onnx";  // without https
  EXPECT_FALSE(FetchNetwork(network_, folder_.path(), {}).ok());
}

TEST_F(Fetching, StopsWhenAsked) {
  const LocalServer server(content_);
  network_.url = server.url();
  std::stop_source stop;
  stop.request_stop();
  WorkContext work;
  work.stop = stop.get_token();
  const auto file = FetchNetwork(network_, folder_.path(), work);
  ASSERT_FALSE(file.ok());
  EXPECT_EQ(file.error().code, ErrorCode::kCancelled);
}

TEST(ListedNetworks, AreWholeAndHaveGoodSidecars) {
  std::set<std::string> names;
  for (const ListedNetwork& network : ListedNetworks()) {
    EXPECT_TRUE(names.insert(network.name).second);
    EXPECT_TRUE(network.url.starts_with("https://"));
    EXPECT_EQ(network.sha256.size(), 64u);
    EXPECT_GT(network.bytes, 0u);
    EXPECT_FALSE(network.licence.empty());
    const auto sidecar = SidecarFromJson(nlohmann::json::parse(network.sidecar));
    EXPECT_TRUE(sidecar.ok()) << network.name;
  }
  EXPECT_GE(names.size(), 2u);
}

TEST(ListedNetworks, HaveTheSumOfTheFileThatWasMeasured) {
  if (!SharedData()) GTEST_SKIP() << kNoSharedData;
  const auto sum = Sha256OfFile(*SharedData() / "models/yolox_nano/yolox_nano.onnx");
  bool listed = false;
  for (const ListedNetwork& network : ListedNetworks()) listed |= network.sha256 == sum.value();
  EXPECT_TRUE(listed);
}

}  // namespace
}  // namespace plumbline
