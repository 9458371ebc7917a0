// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/camera.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "engine/geometry/reach.h"

namespace plumbline {
namespace {

/// One line for each camera model: its name in camera.json and its distortion coefficients.
struct ModelEntry {
  CameraModel model;
  std::string_view name;
  std::size_t min_coefficients, max_coefficients;
  std::string_view coefficients;
};
constexpr ModelEntry kModels[] = {
    {CameraModel::kPinhole, "pinhole", 0, 0, "no distortion"},
    {CameraModel::kRadialTangential, "radial_tangential", 4, 5, "k1 k2 p1 p2 [k3]"},
    {CameraModel::kEquidistant, "equidistant", 4, 4, "k1 k2 k3 k4"},
    {CameraModel::kFov, "fov", 1, 1, "w in radians, between 0 and pi"},
};

/// Below it nothing can be tracked, and what is made smaller first has no pixel left.
constexpr double kFewestPixels = 16;
constexpr double kLargestAspect = 100;
constexpr double kLongestReadOut = 0.2;  ///< [s]

std::string SizeOf(const double* width_and_height) {
  return std::to_string(static_cast<int>(width_and_height[0])) + "x" +
         std::to_string(static_cast<int>(width_and_height[1]));
}

std::string ModelNames() {
  std::string names;
  for (const ModelEntry& entry : kModels) {
    if (!names.empty()) names += ", ";
    names += entry.name;
  }
  return names;
}

Result<double> Number(const nlohmann::json& json, const char* key,
                      const std::filesystem::path& file) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number() || !std::isfinite(found->get<double>())) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' needs a finite number '" + key +
                                               "' (camera intrinsics in pixels)"};
  }
  return found->get<double>();
}

Status ReadDistortion(const nlohmann::json& json, const ModelEntry& model, const auto& bad,
                      std::vector<double>& coefficients) {
  if (const auto distortion = json.find("distortion");
      distortion != json.end() && !distortion->is_null()) {
    if (!distortion->is_array()) return bad("has a 'distortion' that is not a list of numbers");
    for (const auto& value : *distortion) {
      if (!value.is_number() || !std::isfinite(value.template get<double>()))
        return bad("has a 'distortion' with something that is not a finite number");
      coefficients.push_back(value.template get<double>());
    }
  }
  const std::size_t n = coefficients.size();
  if (model.model == CameraModel::kPinhole && n != 0) {
    return bad(
        "is a pinhole camera but has distortion coefficients; name the model radial_tangential or "
        "remove them");
  }
  const bool fov_ok = model.model != CameraModel::kFov || n != 1 ||
                      (coefficients[0] > 0 && coefficients[0] < std::numbers::pi);
  if (n < model.min_coefficients || n > model.max_coefficients || !fov_ok) {
    return bad("needs the distortion coefficients " + std::string(model.coefficients) + " for " +
               std::string(model.name));
  }
  return {};
}

}  // namespace

std::string_view CameraModelName(CameraModel model) {
  return std::find_if(std::begin(kModels), std::end(kModels),
                      [&](const ModelEntry& entry) { return entry.model == model; })
      ->name;
}

PinholeCamera PinholeCamera::Scaled(double factor) const {
  return {static_cast<int>(std::lround(width * factor)),
          static_cast<int>(std::lround(height * factor)),
          fx * factor,
          fy * factor,
          (cx + 0.5) * factor - 0.5,
          (cy + 0.5) * factor - 0.5};
}

Result<Camera> CameraFromJson(const nlohmann::json& json, const std::filesystem::path& file) {
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' " + what};
  };
  if (!json.is_object()) return bad("must hold a JSON object with the camera's intrinsics");
  Camera camera;
  double numbers[6];
  static constexpr const char* kKeys[] = {"width", "height", "fx", "fy", "cx", "cy"};
  for (int i = 0; i < 6; ++i) {
    Result<double> number = Number(json, kKeys[i], file);
    if (!number.ok()) return number.error();
    numbers[i] = *number;
    if (i < 4 && numbers[i] <= 0)
      return bad(std::string("has a '") + kKeys[i] + "' that is not positive");
  }
  if (numbers[0] > 32768 || numbers[1] > 32768 || numbers[0] != std::floor(numbers[0]) ||
      numbers[1] != std::floor(numbers[1])) {
    return bad("has an image size that is not a whole number of at most 32768 pixels");
  }
  const auto [shorter, longer] = std::minmax(numbers[0], numbers[1]);
  if (shorter < kFewestPixels || longer > kLargestAspect * shorter) {
    return bad("has images of " + SizeOf(numbers) +
               " pixels; at least 16 a side are needed, and no side of more than 100 times the "
               "other");
  }
  // Cut out of a larger image, a camera may have its centre outside, but not that far.
  const double largest = 100 * std::max(numbers[0], numbers[1]);
  for (int i = 2; i < 6; ++i) {
    if (std::abs(numbers[i]) > largest)
      return bad(std::string("has a '") + kKeys[i] + "' of more than 100 times its image");
  }
  camera.pinhole = {static_cast<int>(numbers[0]),
                    static_cast<int>(numbers[1]),
                    numbers[2],
                    numbers[3],
                    numbers[4],
                    numbers[5]};
  const auto model = json.find("model");
  if (model == json.end() || !model->is_string())
    return bad("does not name its camera 'model' (" + ModelNames() + ")");
  const auto entry = std::find_if(std::begin(kModels), std::end(kModels),
                                  [&](const ModelEntry& e) { return *model == e.name; });
  if (entry == std::end(kModels)) {
    return Error{ErrorCode::kUnsupported, "'" + file.string() + "' has the camera model '" +
                                              model->get<std::string>() + "'; this version reads " +
                                              ModelNames()};
  }
  camera.model = entry->model;
  if (const Status status = ReadDistortion(json, *entry, bad, camera.distortion); !status.ok())
    return status.error();
  if (json.contains("rate_hz")) {
    Result<double> rate = Number(json, "rate_hz", file);
    if (!rate.ok()) return rate.error();
    if (*rate < 1e-3 || *rate > 1e6)
      return bad("has a 'rate_hz' that is not between 0.001 and 1000000");
    camera.rate_hz = *rate;
  }
  if (const auto read_out = json.find("rolling_shutter_s");
      read_out != json.end() && !read_out->is_null()) {
    if (!read_out->is_number() || !(std::abs(read_out->get<double>()) <= kLongestReadOut))
      return bad("has a 'rolling_shutter_s' that is no number of seconds between -0.2 and 0.2");
    camera.rolling_shutter_s = read_out->get<double>();
  }
  if (const auto pose = json.find("body_from_cam"); pose != json.end() && !pose->is_null()) {
    Eigen::Matrix4d matrix;
    try {
      for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) matrix(r, c) = pose->at(r).at(c).get<double>();
      }
    } catch (const nlohmann::json::exception&) {
      return bad("has a 'body_from_cam' that is not a 4x4 matrix");
    }
    if (!matrix.allFinite() || matrix.topRightCorner<3, 1>().cwiseAbs().maxCoeff() > kFarthest_m ||
        !(matrix.topLeftCorner<3, 3>() * matrix.topLeftCorner<3, 3>().transpose())
             .isIdentity(1e-3) ||
        matrix.topLeftCorner<3, 3>().determinant() < 0) {
      return bad("has a 'body_from_cam' that is no rigid transform within 1000 km");
    }
    camera.body_from_cam = Eigen::Isometry3d(matrix);
  }
  return camera;
}

nlohmann::json IntrinsicsToJson(const PinholeCamera& camera) {
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
          {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy}};
}

nlohmann::json CameraToJson(const Camera& camera) {
  nlohmann::json json = IntrinsicsToJson(camera.pinhole);
  json["distortion"] = camera.distortion;
  json["rate_hz"] = camera.rate_hz;
  json["model"] = CameraModelName(camera.model);
  if (camera.rolling_shutter_s != 0) json["rolling_shutter_s"] = camera.rolling_shutter_s;
  if (camera.body_from_cam) {
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c)
        json["body_from_cam"][r][c] = camera.body_from_cam->matrix()(r, c);
    }
  }
  return json;
}

}  // namespace plumbline
