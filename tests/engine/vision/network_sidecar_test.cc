// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/network_sidecar.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/vision/detector.h"
#include "engine/vision/edge_detector.h"
#include "engine/vision/network.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_network.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Sidecar : public testing::Test {
 protected:
  Result<NetworkSidecar> Read(const std::string& text) {
    WriteText(folder_.path() / "net.json", text);
    return ReadNetworkSidecar(folder_.path() / "net.onnx");
  }
  std::string Refusal(const char* key, const nlohmann::json& value) {
    nlohmann::json json = edge_;
    json[key] = value;
    const Result<NetworkSidecar> sidecar = Read(json.dump());
    return sidecar.ok() ? "accepted" : sidecar.error().message;
  }
  TemporaryFolder folder_;
  const nlohmann::json edge_ = {{"kind", "edge"},
                                {"width", 640},
                                {"height", 480},
                                {"mean", {104, 117, 123}},
                                {"scale", 0.5},
                                {"swap_rb", true},
                                {"calibration", {{0, 0}, {0.5, 0.2}, {1, 0.9}}}};
};

TEST_F(Sidecar, IsReadAsWritten) {
  const Result<NetworkSidecar> sidecar = Read(edge_.dump());
  ASSERT_TRUE(sidecar.ok()) << sidecar.error().message;
  EXPECT_EQ(sidecar->kind, NetworkKind::kEdge);
  EXPECT_EQ(sidecar->width, 640);
  EXPECT_EQ(sidecar->height, 480);
  EXPECT_EQ(sidecar->mean, cv::Scalar(104, 117, 123));
  EXPECT_EQ(sidecar->scale, 0.5);
  EXPECT_TRUE(sidecar->swap_rb);
  EXPECT_THAT(sidecar->calibration,
              ElementsAre(std::pair(0.0f, 0.0f), std::pair(0.5f, 0.2f), std::pair(1.0f, 0.9f)));
}

TEST_F(Sidecar, WrittenOtherwiseAndElsewhereTheNetworkIsTheSame) {
  const auto hash = [&](const std::string& folder, const std::string& text) {
    std::filesystem::create_directories(folder_.path() / folder);
    WriteText(folder_.path() / folder / "net.onnx", folder == "other" ? "weights 2" : "weights");
    WriteText(folder_.path() / folder / "net.json", text);
    return HashOfNetwork(folder_.path() / folder / "net.onnx").value();
  };
  const std::string first = hash("a", edge_.dump());
  EXPECT_EQ(hash("b", "// reformatted\n" + edge_.dump(4) + "\n"), first);
  nlohmann::json said = edge_;
  said["std"] = {1, 1, 1};  // as if it were not there
  EXPECT_EQ(hash("c", said.dump()), first);
  said["scale"] = 0.25;
  EXPECT_NE(hash("d", said.dump()), first);
  EXPECT_NE(hash("other", edge_.dump()), first);
}

TEST_F(Sidecar, IsRefusedWithTheFileAndTheKey) {
  for (const auto& [key, value] :
       std::vector<std::pair<const char*, nlohmann::json>>{{"width", 0},
                                                           {"height", 1.5},
                                                           {"height", "480"},
                                                           {"mean", {1, 2}},
                                                           {"mean", "none"},
                                                           {"scale", 0},
                                                           {"scale", nullptr},
                                                           {"swap_rb", 1},
                                                           {"calibration", {{0, 0}}},
                                                           {"calibration", {{0, 0}, {0, 1}}},
                                                           {"calibration", {{0, 0.5}, {1, 0.2}}},
                                                           {"calibration", {{0, 0}, {1, 2}}},
                                                           {"calibration", 3}}) {
    EXPECT_THAT(Refusal(key, value), HasSubstr("'" + std::string(key) + "'")) << value;
    EXPECT_THAT(Refusal(key, value), HasSubstr("net.json"));
  }
  EXPECT_THAT(Refusal("kind", "yolo"), HasSubstr("'yolo'"));
  EXPECT_THAT(Refusal("kind", "fastestdet"), HasSubstr("categories"));
  EXPECT_FALSE(Read("[]").ok());
  EXPECT_FALSE(Read("{").ok());
}

TEST_F(Sidecar, OfANetworkThatIsNotThereIsNotWhatIsMissing) {
  const Result<NetworkSidecar> sidecar = ReadNetworkSidecar(folder_.path() / "net.onnx");
  ASSERT_FALSE(sidecar.ok());
  EXPECT_EQ(sidecar.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(sidecar.error().message, HasSubstr("there is no network"));
  EXPECT_THAT(sidecar.error().message, HasSubstr("net.onnx"));
}

TEST_F(Sidecar, MissingIsSaidSo) {
  WriteText(folder_.path() / "net.onnx", "any");
  const Result<NetworkSidecar> sidecar = ReadNetworkSidecar(folder_.path() / "net.onnx");
  ASSERT_FALSE(sidecar.ok());
  EXPECT_EQ(sidecar.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(sidecar.error().message, HasSubstr("no sidecar"));
}

TEST_F(Sidecar, BesideANetworkThatIsNoneIsAnError) {
  WriteText(folder_.path() / "net.json", edge_.dump());
  EXPECT_EQ(LoadNetwork(folder_.path() / "net.onnx").error().code, ErrorCode::kNotFound);
  for (const char* content : {"", "garbage garbage garbage", "\x08\x07\x12\x02hi"}) {
    WriteText(folder_.path() / "net.onnx", content);
    const Result<Network> network = LoadNetwork(folder_.path() / "net.onnx");
    ASSERT_FALSE(network.ok());
    EXPECT_THAT(network.error().message, HasSubstr("net.onnx"));
  }
}

TEST_F(Sidecar, OfAnotherKindThanWantedIsAnError) {
  const std::filesystem::path file = folder_.path() / "net.onnx";
  WriteTinyNetwork(file, {.kind = NetworkKind::kEdge});
  WriteText(folder_.path() / "net.json",
            R"({"kind": "edge", "width": 64, "height": 64, "scale": 1})");
  EXPECT_TRUE(CreateEdgeDetector(file.string(), nullptr).ok());
  const auto as_detector = CreateDetector(file.string(), nullptr);
  ASSERT_FALSE(as_detector.ok());
  EXPECT_EQ(as_detector.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(as_detector.error().message, HasSubstr("--edges"));
  WriteTinyNetwork(file, {.kind = NetworkKind::kYolox, .categories = 80});
  WriteText(folder_.path() / "net.json",
            R"({"kind": "yolox", "width": 64, "height": 64, "scale": 1, "categories": "coco"})");
  EXPECT_TRUE(CreateDetector(file.string(), nullptr).ok());
  const auto as_edges = CreateEdgeDetector(file.string(), nullptr);
  ASSERT_FALSE(as_edges.ok());
  EXPECT_THAT(as_edges.error().message, HasSubstr("--detector"));
}

TEST_F(Sidecar, OfAnEdgeNetworkMayLeaveTheSizeToTheImage) {
  const Result<NetworkSidecar> sidecar =
      Read(R"({"kind": "edge", "multiple_of": 16, "shrink": 2, "scale": 0.1})");
  ASSERT_TRUE(sidecar.ok()) << sidecar.error().message;
  EXPECT_EQ(sidecar->multiple_of, 16);
  EXPECT_EQ(sidecar->shrink, 2);
  EXPECT_FALSE(Read(R"({"kind": "yolox", "multiple_of": 16, "scale": 1})").ok());
}

TEST_F(Sidecar, SaysWhichDetectorsValuesMakeNoSense) {
  const nlohmann::json good = {
      {"kind", "yolox"}, {"width", 64}, {"height", 64}, {"scale", 1}, {"categories", "voc"}};
  ASSERT_TRUE(Read(good.dump()).ok());
  EXPECT_EQ(Read(good.dump())->categories[17], "couch");
  for (const auto& [key, value] :
       std::vector<std::pair<const char*, nlohmann::json>>{{"std", {1, 0, 1}},
                                                           {"resize", "crop"},
                                                           {"padding", -1},
                                                           {"strides", {8, 0}},
                                                           {"strides", 8},
                                                           {"categories", "imagenet"}}) {
    nlohmann::json json = good;
    json[key] = value;
    const Result<NetworkSidecar> sidecar = Read(json.dump());
    ASSERT_FALSE(sidecar.ok()) << key << value;
    EXPECT_THAT(sidecar.error().message, HasSubstr(key));
  }
}

}  // namespace
}  // namespace plumbline
