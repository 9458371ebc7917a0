// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/camera.h"

#include <array>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace plumbline {
namespace {

nlohmann::json Kitchen() {
  return {{"width", 640},
          {"height", 480},
          {"model", "radial_tangential"},
          {"fx", 511.0},
          {"fy", 512.0},
          {"cx", 320.5},
          {"cy", 240.5},
          {"distortion", {-0.28, 0.07, 0.0002, 1.8e-5}},
          {"rate_hz", 30.0}};
}

TEST(Camera, SurvivesARoundTripThroughJson) {
  nlohmann::json json = Kitchen();
  json["body_from_cam"] = {{0, 0, 1, 0.1}, {-1, 0, 0, 0.2}, {0, -1, 0, 0.3}, {0, 0, 0, 1}};
  json["rolling_shutter_s"] = -0.015;
  const Result<Camera> camera = CameraFromJson(json, "camera.json");
  ASSERT_TRUE(camera.ok()) << camera.error().message;
  EXPECT_EQ(camera->rolling_shutter_s, -0.015);
  const Result<Camera> again = CameraFromJson(CameraToJson(*camera), "camera.json");
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(again->pinhole, camera->pinhole);
  EXPECT_EQ(again->distortion, camera->distortion);
  EXPECT_EQ(again->rolling_shutter_s, camera->rolling_shutter_s);
  EXPECT_TRUE(again->body_from_cam->isApprox(*camera->body_from_cam, 1e-15));
}

TEST(Camera, KnowsWhenEachRowIsExposed) {
  Camera camera;
  camera.pinhole = {640, 481, 500, 500, 319.5, 240};
  EXPECT_EQ(camera.RowDelay(0), 0);
  EXPECT_FALSE(CameraToJson(camera).contains("rolling_shutter_s"));
  camera.rolling_shutter_s = 0.02;
  EXPECT_DOUBLE_EQ(camera.RowDelay(0), -0.01);
  EXPECT_DOUBLE_EQ(camera.RowDelay(240), 0);
  EXPECT_DOUBLE_EQ(camera.RowDelay(480), 0.01);
}

TEST(Camera, RefusesWhatItCannotUseAndNamesTheFile) {
  const auto message = [](const char* key, const nlohmann::json& value) {
    nlohmann::json json = Kitchen();
    json[key] = value;
    const Result<Camera> camera = CameraFromJson(json, "some/camera.json");
    return camera.ok() ? std::string("accepted") : camera.error().message;
  };
  for (const auto& [key, value] : std::vector<std::pair<const char*, nlohmann::json>>{
           {"width", 0},
           {"height", -3},
           {"fx", 0},
           {"fy", nullptr},
           {"cx", "mid"},
           {"cy", 1e30},
           {"fx", 1e9},
           {"model", "fisheye624"},
           {"model", 3},
           {"distortion", {1, 2}},
           {"distortion", "none"},
           {"rolling_shutter_s", 0.21},
           {"rolling_shutter_s", "fast"},
           {"rolling_shutter_s", 1e300},
           {"rate_hz", 0},
           {"rate_hz", 1e-300},
           {"rate_hz", 1e300},
           {"width", 1e9},
           {"width", 1},
           {"height", 4},
           {"height", 0.5},
           {"body_from_cam", {1, 2, 3}},
           {"body_from_cam", {{1, 0, 0, 1e300}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}},
           {"body_from_cam", {{2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 2, 0}, {0, 0, 0, 1}}}}) {
    EXPECT_NE(message(key, value).find("some/camera.json"), std::string::npos) << key << value;
  }
  EXPECT_FALSE(CameraFromJson(nlohmann::json::array(), "c.json").ok());
  EXPECT_EQ(CameraFromJson({{"width", 1}}, "c.json").error().code, ErrorCode::kInvalidInput);
}

TEST(Camera, SaysThatAStripOfPixelsIsNoImage) {
  nlohmann::json json = Kitchen();
  json["width"] = 1;
  const Result<Camera> camera = CameraFromJson(json, "camera.json");
  ASSERT_FALSE(camera.ok());
  EXPECT_THAT(camera.error().message, testing::HasSubstr("images of 1x480 pixels; at least 16"));
  json["width"] = 16;  // the narrowest that goes
  EXPECT_TRUE(CameraFromJson(json, "camera.json").ok());
}

TEST(Camera, SaysWhichModelItDoesNotKnow) {
  nlohmann::json json = Kitchen();
  json["model"] = "omnidirectional";
  const Result<Camera> camera = CameraFromJson(json, "camera.json");
  ASSERT_FALSE(camera.ok());
  EXPECT_EQ(camera.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(
      camera.error().message.find(
          "'omnidirectional'; this version reads pinhole, radial_tangential, equidistant, fov"),
      std::string::npos);
}

TEST(PinholeCamera, ScalesAboutTheImageCornerNotThePixelCentre) {
  const PinholeCamera camera{640, 480, 500, 500, 319.5, 239.5};
  const PinholeCamera half = camera.Scaled(0.5);
  EXPECT_EQ(half.width, 320);
  EXPECT_DOUBLE_EQ(half.cx, 159.5);  // the middle stays the middle
  const Eigen::Vector2d pixel = camera.Project({0.1, -0.2, 2});
  const Eigen::Vector2d half_pixel = half.Project({0.1, -0.2, 2});
  EXPECT_NEAR(half_pixel.x(), (pixel.x() + 0.5) / 2 - 0.5, 1e-12);
}

TEST(Camera, ReadsTheCoefficientsOfEachModel) {
  const auto read = [](const char* model, const nlohmann::json& distortion) {
    nlohmann::json json = Kitchen();
    json["model"] = model;
    json["distortion"] = distortion;
    const Result<Camera> camera = CameraFromJson(json, "camera.json");
    return camera.ok() ? std::string(CameraModelName(camera->model)) : camera.error().message;
  };
  using testing::HasSubstr;
  const auto none = nlohmann::json::array();
  EXPECT_EQ(read("pinhole", none), "pinhole");
  EXPECT_EQ(read("equidistant", {0.1, 0.01, 0, 0}), "equidistant");
  EXPECT_EQ(read("fov", {0.93}), "fov");
  EXPECT_THAT(read("fov", none), HasSubstr("w in radians"));
  EXPECT_THAT(read("fov", {-0.93}), HasSubstr("w in radians"));
  EXPECT_THAT(read("fov", {3.2}), HasSubstr("w in radians"));
  EXPECT_THAT(read("equidistant", {0.1, 0.01}), HasSubstr("k1 k2 k3 k4"));
  EXPECT_THAT(read("equidistant", {0.1, 0.01, 0, 0, 0}), HasSubstr("k1 k2 k3 k4"));
  EXPECT_THAT(read("radial_tangential", {0.1, 0.01, 0}), HasSubstr("k1 k2 p1 p2"));
}

TEST(PinholeCamera, ScalesACameraWhoseAxisIsOffCentre) {
  const PinholeCamera camera{960, 500, 610, 612, 471.3, 262.9};
  for (const double factor : {0.5, 0.25, 1.0 / 3.0, 2.0}) {
    const PinholeCamera scaled = camera.Scaled(factor);
    const Eigen::Vector3d point(-0.3, 0.4, 1.7);
    const Eigen::Vector2d corner(
        0.5, 0.5);  // pixel centres at integers: the image's corner is at (-0.5, -0.5)
    EXPECT_LT((scaled.Project(point) - (factor * (camera.Project(point) + corner) - corner)).norm(),
              1e-12);
    EXPECT_LT((scaled.Bearing(scaled.Project(point)) - point.hnormalized()).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace plumbline
