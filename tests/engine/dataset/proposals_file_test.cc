// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/proposals_file.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

class ProposalsFile : public testing::Test {
 protected:
  Result<std::vector<Detection>> Read(const std::string& text) {
    WriteText(file_, text);
    return ReadProposalsFile(file_);
  }
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "000000.json";
  const std::vector<Detection> boxes_ = {{{1, 2, 30, 40.5f}, "chair", 0.5f},
                                         {{0, 0, 9, 9}, "dining table", 0.25f}};
};

TEST_F(ProposalsFile, IsReadInTheFormsInWhichDetectWritesIt) {
  const nlohmann::json json = ProposalsToJson("a.jpg", boxes_);
  for (const nlohmann::json& form : {json, nlohmann::json::array({json}), json["boxes"]}) {
    const Result<std::vector<Detection>> read = Read(form.dump());
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_EQ(read->size(), 2u);
    EXPECT_EQ((*read)[0].box, boxes_[0].box);
    EXPECT_EQ((*read)[1].category, "dining table");
    EXPECT_EQ((*read)[1].score, 0.25f);
  }
  EXPECT_TRUE(Read("[]").value().empty());
}

TEST_F(ProposalsFile, RefusesABoxThatIsNone) {
  for (const char* box : {R"({"x0":5,"y0":0,"x1":1,"y1":1,"category":"c","score":0.5})",
                          R"({"x0":0,"y0":0,"x1":1,"y1":1,"category":"c","score":1.5})",
                          R"({"x0":0,"y0":0,"x1":1e99,"y1":1,"category":"c","score":0.5})",
                          R"({"x0":0,"y0":0,"x1":1,"y1":1,"score":0.5})",
                          R"({"x0":0,"y0":0,"x1":1,"category":"c","score":0.5})", "7", "null"}) {
    const Result<std::vector<Detection>> read = Read(std::string("[") + box + ", 3]");
    ASSERT_FALSE(read.ok()) << box;
    EXPECT_THAT(read.error().message, HasSubstr("000000.json"));
  }
  EXPECT_FALSE(Read("{}").ok());
  EXPECT_FALSE(Read("").ok());
}

}  // namespace
}  // namespace plumbline
