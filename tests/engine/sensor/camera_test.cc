// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/camera.h"

#include <array>

#include <gtest/gtest.h>
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
  const Result<Camera> camera = CameraFromJson(json, "camera.json");
  ASSERT_TRUE(camera.ok()) << camera.error().message;
  const Result<Camera> again = CameraFromJson(CameraToJson(*camera), "camera.json");
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(again->pinhole, camera->pinhole);
  EXPECT_EQ(again->distortion, camera->distortion);
  EXPECT_TRUE(again->body_from_cam->isApprox(*camera->body_from_cam, 1e-15));
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
           {"model", "fisheye624"},
           {"model", 3},
           {"distortion", {1, 2}},
           {"distortion", "none"},
           {"rate_hz", 0},
           {"width", 1e9},
           {"height", 0.5},
           {"body_from_cam", {1, 2, 3}},
           {"body_from_cam", {{2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 2, 0}, {0, 0, 0, 1}}}}) {
    EXPECT_NE(message(key, value).find("some/camera.json"), std::string::npos) << key << value;
  }
  EXPECT_FALSE(CameraFromJson(nlohmann::json::array(), "c.json").ok());
  EXPECT_EQ(CameraFromJson({{"width", 1}}, "c.json").error().code, ErrorCode::kInvalidInput);
}

TEST(Camera, SaysWhichModelItDoesNotKnow) {
  nlohmann::json json = Kitchen();
  json["model"] = "equidistant";
  const Result<Camera> camera = CameraFromJson(json, "camera.json");
  ASSERT_FALSE(camera.ok());
  EXPECT_EQ(camera.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(camera.error().message.find("equidistant"), std::string::npos);
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

TEST(Undistorter, LeavesPinholeImagesAlone) {
  Camera camera;
  camera.pinhole = {4, 3, 2, 2, 1.5, 1};
  const cv::Mat image(3, 4, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(Undistorter(camera).Undistort(image).data, image.data);
  EXPECT_EQ(Undistorter(camera).UndistortPixel({2, 1}), Eigen::Vector2d(2, 1));
}

TEST(Undistorter, InvertsTheClosedFormOfTheLens) {
  nlohmann::json json = Kitchen();
  json["distortion"] = {-0.28, 0.07, 0.0002, 1.8e-5, -0.01};
  const Camera camera = CameraFromJson(json, "camera.json").value();
  const Undistorter undistorter(camera);
  const auto [k1, k2, p1, p2, k3] = std::array{-0.28, 0.07, 0.0002, 1.8e-5, -0.01};
  for (double v = 40; v < 480; v += 80) {
    for (double u = 40; u < 640; u += 80) {
      const Eigen::Vector2d ideal = camera.pinhole.Bearing({u, v});
      const double x = ideal.x(), y = ideal.y(), r2 = ideal.squaredNorm();
      const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
      const Eigen::Vector3d bent(x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                                 y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y, 1);
      EXPECT_LT(
          (undistorter.UndistortPixel(camera.pinhole.Project(bent)) - Eigen::Vector2d(u, v)).norm(),
          0.05)
          << u << " " << v;
    }
  }
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

TEST(Undistorter, MovesImageAndPixelAlike) {
  const Camera camera = CameraFromJson(Kitchen(), "camera.json").value();
  const Undistorter undistorter(camera);
  // A soft blob so that its centre is known below a pixel.
  cv::Mat image(480, 640, CV_8UC1);
  const Eigen::Vector2d blob(100, 80);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      image.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(
          250 * std::exp(-(Eigen::Vector2d(x, y) - blob).squaredNorm() / (2 * 5.0 * 5.0)));
    }
  }
  const cv::Mat result = undistorter.Undistort(image);
  double sum = 0;
  Eigen::Vector2d centre(0, 0);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      sum += result.at<unsigned char>(y, x);
      centre += result.at<unsigned char>(y, x) * Eigen::Vector2d(x, y);
    }
  }
  // The blob is a little stretched, which moves its centre of mass by a fraction of a pixel.
  EXPECT_LT((centre / sum - undistorter.UndistortPixel(blob)).norm(), 0.5);
  EXPECT_GT((undistorter.UndistortPixel(blob) - blob).norm(), 3);
}

}  // namespace
}  // namespace plumbline
