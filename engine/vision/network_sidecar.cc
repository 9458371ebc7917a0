// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/network_sidecar.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"
#include "engine/vision/category_names.h"

namespace plumbline {
namespace {

using Problem = std::optional<std::string>;

template <typename T>
Problem ReadName(const nlohmann::json& sidecar, const char* key, T& value) {
  const std::string name = TextFromJson(sidecar, key).value_or("");
  std::string known;
  for (std::size_t i = 0; i < std::size(EnumNames<T>::names); ++i) {
    if (EnumNames<T>::names[i] == name) {
      value = static_cast<T>(i);
      return std::nullopt;
    }
    known += (i == 0 ? "" : ", ") + std::string(EnumNames<T>::names[i]);
  }
  return "has the " + std::string(key) + " '" + name + "'; this version knows " + known;
}

Problem ReadWholeNumber(const nlohmann::json& sidecar, const char* key, int& value) {
  if (!sidecar.contains(key) || !sidecar[key].is_number_integer() || sidecar[key] < 1 ||
      sidecar[key] > 8192) {
    return "needs a whole number '" + std::string(key) + "' of 1 to 8192 pixels";
  }
  value = sidecar[key].get<int>();
  return std::nullopt;
}

Problem ReadSize(const nlohmann::json& sidecar, NetworkSidecar& result) {
  if (result.kind == NetworkKind::kEdge && sidecar.contains("shrink")) {
    if (const Problem problem = ReadWholeNumber(sidecar, "shrink", result.shrink)) return problem;
  }
  if (result.kind == NetworkKind::kEdge && sidecar.contains("multiple_of"))
    return ReadWholeNumber(sidecar, "multiple_of", result.multiple_of);
  if (const Problem problem = ReadWholeNumber(sidecar, "width", result.width)) return problem;
  return ReadWholeNumber(sidecar, "height", result.height);
}

Problem ReadNumber(const nlohmann::json& sidecar, const char* key, double least, double& value) {
  if (!sidecar[key].is_number() || !std::isfinite(sidecar[key].get<double>()) ||
      sidecar[key].get<double>() < least) {
    return "has a '" + std::string(key) + "' that is no number of at least " +
           (least == 0 ? "0" : "0.000001");
  }
  value = sidecar[key].get<double>();
  return std::nullopt;
}

Problem ReadValues(const nlohmann::json& sidecar, NetworkSidecar& result) {
  constexpr double kLeast = 1e-6;  // of what is divided by or multiplied with
  for (const auto& [key, value] :
       {std::pair{"mean", &result.mean}, std::pair{"std", &result.deviation}}) {
    if (!sidecar.contains(key)) continue;
    const std::optional<Eigen::VectorXd> three = VectorFromJson(sidecar[key], 3);
    if (!three || (value == &result.deviation && three->minCoeff() < kLeast))
      return "has a '" + std::string(key) + "' that is not three " +
             (value == &result.mean ? "numbers" : "positive numbers");
    *value = cv::Scalar((*three)[0], (*three)[1], (*three)[2]);
  }
  if (!sidecar.contains("scale")) return "needs a positive number 'scale'";
  if (const Problem problem = ReadNumber(sidecar, "scale", kLeast, result.scale)) return problem;
  if (sidecar.contains("padding")) {
    if (const Problem problem = ReadNumber(sidecar, "padding", 0, result.padding)) return problem;
  }
  if (sidecar.contains("swap_rb")) {
    if (!sidecar["swap_rb"].is_boolean()) return "has a 'swap_rb' that is neither true nor false";
    result.swap_rb = sidecar["swap_rb"].get<bool>();
  }
  return sidecar.contains("resize") ? ReadName(sidecar, "resize", result.fit) : std::nullopt;
}

std::vector<int> UsualStrides(NetworkKind kind) {
  switch (kind) {
    case NetworkKind::kFastestDet:
      return {16};
    case NetworkKind::kYolox:
    case NetworkKind::kYolov8:
    case NetworkKind::kYolov10:
      return {8, 16, 32};
    case NetworkKind::kPicodet:
    case NetworkKind::kNanodet:
      return {8, 16, 32, 64};
    default:
      return {};
  }
}

Problem ReadStrides(const nlohmann::json& sidecar, NetworkSidecar& result) {
  result.strides = UsualStrides(result.kind);
  const auto found = sidecar.find("strides");
  if (found == sidecar.end()) return std::nullopt;
  const bool whole = found->is_array() && !found->empty() &&
                     std::all_of(found->begin(), found->end(), [](const nlohmann::json& stride) {
                       return stride.is_number_integer() && stride >= 1 && stride <= 1024;
                     });
  if (!whole) return "has 'strides' that are no list of whole numbers of 1 to 1024 pixels";
  result.strides = found->get<std::vector<int>>();
  return std::nullopt;
}

Problem ReadCategories(const nlohmann::json& sidecar, NetworkSidecar& result) {
  const auto found = sidecar.find("categories");
  if (found != sidecar.end() && found->is_string() && (*found == "coco" || *found == "voc")) {
    const auto names = *found == "coco" ? CocoCategories() : VocCategories();
    result.categories.assign(names.begin(), names.end());
    return std::nullopt;
  }
  if (found == sidecar.end() || !found->is_array() || found->empty()) {
    return "needs its 'categories': coco, voc, or a list of names in the order of the network";
  }
  for (const nlohmann::json& name : *found) {
    if (!name.is_string()) return "has a category that is not a text";
    result.categories.push_back(CategoryName(name.get<std::string>()));
  }
  return std::nullopt;
}

Problem ReadCalibration(const nlohmann::json& sidecar, NetworkSidecar& result) {
  const auto found = sidecar.find("calibration");
  if (found == sidecar.end() || found->is_null()) return std::nullopt;
  const std::string wanted =
      "has a 'calibration' that is not a list of [raw, probability], both rising in 0..1";
  if (!found->is_array() || found->size() < 2) return wanted;
  for (const nlohmann::json& entry : *found) {
    const std::optional<Eigen::VectorXd> pair = VectorFromJson(entry, 2);
    if (!pair || pair->minCoeff() < 0 || pair->maxCoeff() > 1) return wanted;
    const std::pair<float, float> point((*pair)[0], (*pair)[1]);
    auto& curve = result.calibration;
    if (!curve.empty() && (point.first <= curve.back().first || point.second < curve.back().second))
      return wanted;
    curve.push_back(point);
  }
  return std::nullopt;
}

std::vector<double> Three(const cv::Scalar& scalar) { return {scalar[0], scalar[1], scalar[2]}; }

}  // namespace

std::string_view NameOf(NetworkKind kind) {
  return EnumNames<NetworkKind>::names[static_cast<std::size_t>(kind)];
}

Result<NetworkSidecar> SidecarFromJson(const nlohmann::json& json) {
  if (!json.is_object()) return Error{ErrorCode::kInvalidInput, "must hold a JSON object"};
  NetworkSidecar result;
  if (const Problem problem = ReadName(json, "kind", result.kind))
    return Error{ErrorCode::kUnsupported, *problem};
  Problem problem = ReadSize(json, result);
  if (!problem) problem = ReadValues(json, result);
  if (!problem) problem = ReadStrides(json, result);
  if (!problem && result.kind != NetworkKind::kEdge) problem = ReadCategories(json, result);
  if (!problem) problem = ReadCalibration(json, result);
  if (!problem && result.kind == NetworkKind::kTwoStage) {
    // Two networks and torchvision's anchors know of one way to fit an image.
    if (result.fit != ImageFit::kLetterbox) problem = "needs 'resize' to be letterbox";
    if (!problem) problem = ReadTwoStage(json, result.strides.size(), result.two_stage);
  }
  if (problem) return Error{ErrorCode::kInvalidInput, *problem};
  return result;
}

nlohmann::json SidecarToJson(const NetworkSidecar& sidecar) {
  nlohmann::json json = {{"kind", NameOf(sidecar.kind)},
                         {"mean", Three(sidecar.mean)},
                         {"std", Three(sidecar.deviation)},
                         {"scale", sidecar.scale},
                         {"swap_rb", sidecar.swap_rb}};
  if (sidecar.multiple_of > 0) {
    json["multiple_of"] = sidecar.multiple_of;
  } else {
    json["width"] = sidecar.width;
    json["height"] = sidecar.height;
  }
  if (sidecar.shrink > 1) json["shrink"] = sidecar.shrink;
  if (sidecar.kind != NetworkKind::kEdge) {
    json["resize"] = EnumNames<ImageFit>::names[static_cast<std::size_t>(sidecar.fit)];
    if (sidecar.kind == NetworkKind::kTwoStage) {
      WriteTwoStage(sidecar.two_stage, json);
    } else if (sidecar.fit != ImageFit::kStretch) {
      json["padding"] = sidecar.padding;
    }
    if (!sidecar.strides.empty()) json["strides"] = sidecar.strides;
    json["categories"] = sidecar.categories;
  }
  if (!sidecar.calibration.empty()) json["calibration"] = sidecar.calibration;
  return json;
}

Result<NetworkSidecar> ReadNetworkSidecar(const std::filesystem::path& onnx_file) {
  std::filesystem::path file = onnx_file;
  file.replace_extension(".json");
  const Result<nlohmann::json> read = ReadJson(file);
  if (!read.ok()) {
    if (read.error().code != ErrorCode::kNotFound) return read.error();
    std::error_code ignored;
    if (!std::filesystem::exists(onnx_file, ignored)) {
      return Error{ErrorCode::kNotFound,
                   "there is no network '" + onnx_file.string() + "'; give the path of its file"};
    }
    return Error{ErrorCode::kNotFound,
                 "the network '" + onnx_file.string() + "' has no sidecar '" + file.string() +
                     "' that says how to feed it; 'plumbline networks check " + onnx_file.string() +
                     " --write' makes one for the usual exports"};
  }
  Result<NetworkSidecar> sidecar = SidecarFromJson(*read);
  if (sidecar.ok()) return sidecar;
  return Error{sidecar.error().code,
               "the network's sidecar '" + file.string() + "' " + sidecar.error().message};
}

}  // namespace plumbline
