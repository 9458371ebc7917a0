// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/network_sidecar.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

std::optional<std::string> ReadKind(const nlohmann::json& sidecar, NetworkKind& kind) {
  const std::string name = TextFromJson(sidecar, "kind").value_or("");
  if (name == "edge") {
    kind = NetworkKind::kEdge;
  } else if (name == "fastestdet") {
    kind = NetworkKind::kFastestDet;
  } else if (name == "two_stage") {
    kind = NetworkKind::kTwoStage;
  } else {
    return "has the kind '" + name + "'; this version knows edge, fastestdet and two_stage";
  }
  return std::nullopt;
}

std::optional<std::string> ReadInput(const nlohmann::json& sidecar, NetworkSidecar& result) {
  for (const auto& [key, value] :
       {std::pair{"width", &result.width}, std::pair{"height", &result.height}}) {
    if (!sidecar.contains(key) || !sidecar[key].is_number_integer() || sidecar[key] < 1 ||
        sidecar[key] > 8192) {
      return "needs a whole number '" + std::string(key) + "' of 1 to 8192 pixels";
    }
    *value = sidecar[key].get<int>();
  }
  if (sidecar.contains("mean")) {
    const std::optional<Eigen::VectorXd> mean = VectorFromJson(sidecar["mean"], 3);
    if (!mean) return "has a 'mean' that is not three numbers";
    result.mean = cv::Scalar((*mean)[0], (*mean)[1], (*mean)[2]);
  }
  if (!sidecar.contains("scale") || !sidecar["scale"].is_number() ||
      !(sidecar["scale"].get<double>() > 0) || !std::isfinite(sidecar["scale"].get<double>())) {
    return "needs a positive number 'scale'";
  }
  result.scale = sidecar["scale"].get<double>();
  if (sidecar.contains("swap_rb")) {
    if (!sidecar["swap_rb"].is_boolean()) return "has a 'swap_rb' that is neither true nor false";
    result.swap_rb = sidecar["swap_rb"].get<bool>();
  }
  return std::nullopt;
}

std::optional<std::string> ReadCategories(const nlohmann::json& sidecar, NetworkSidecar& result) {
  const auto found = sidecar.find("categories");
  if (found == sidecar.end() || !found->is_array() || found->empty()) {
    return "needs the names of its 'categories' (COCO names, in the order of the network)";
  }
  for (const nlohmann::json& name : *found) {
    if (!name.is_string()) return "has a category that is not a text";
    result.categories.push_back(name.get<std::string>());
  }
  return std::nullopt;
}

std::optional<std::string> ReadCalibration(const nlohmann::json& sidecar, NetworkSidecar& result) {
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

}  // namespace

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
    return Error{ErrorCode::kNotFound, "the network '" + onnx_file.string() + "' has no sidecar '" +
                                           file.string() +
                                           "' that says how to feed it (docs/formats.md)"};
  }
  const auto error = [&](ErrorCode code, const std::string& what) {
    return Error{code, "the network's sidecar '" + file.string() + "' " + what};
  };
  const nlohmann::json& sidecar = read.value();
  if (!sidecar.is_object()) return error(ErrorCode::kInvalidInput, "must hold a JSON object");
  NetworkSidecar result;
  if (const auto problem = ReadKind(sidecar, result.kind))
    return error(ErrorCode::kUnsupported, *problem);
  if (const auto problem = ReadInput(sidecar, result))
    return error(ErrorCode::kInvalidInput, *problem);
  if (result.kind != NetworkKind::kEdge) {
    if (const auto problem = ReadCategories(sidecar, result))
      return error(ErrorCode::kInvalidInput, *problem);
  }
  if (const auto problem = ReadCalibration(sidecar, result))
    return error(ErrorCode::kInvalidInput, *problem);
  return result;
}

Result<Network> LoadNetwork(const std::filesystem::path& onnx_file, NetworkKind kind,
                            const std::vector<int>& output_shape) {
  const Result<std::string> bytes = ReadFile(onnx_file);
  if (!bytes.ok()) return bytes.error();
  Result<NetworkSidecar> sidecar = ReadNetworkSidecar(onnx_file);
  if (!sidecar.ok()) return sidecar.error();
  const auto error = [&](ErrorCode code, const std::string& what) {
    return Error{code, "the network '" + onnx_file.string() + "' " + what};
  };
  if (sidecar->kind != kind) {
    return error(ErrorCode::kInvalidInput, kind == NetworkKind::kEdge
                                               ? "finds no edges (its sidecar's kind is not edge)"
                                               : "finds no objects (see its sidecar's kind)");
  }
  const Result<std::string> sidecar_hash =
      HashFile(std::filesystem::path(onnx_file).replace_extension(".json"));
  if (!sidecar_hash.ok()) return sidecar_hash.error();
  Network network{
      {}, std::move(sidecar).value(), onnx_file, HashHex(bytes.value()) + *sidecar_hash};
  try {
    network.net = cv::dnn::readNetFromONNX(bytes.value().data(), bytes.value().size());
    network.net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network.net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  } catch (const std::exception&) {
    return error(ErrorCode::kCorrupt,
                 "is damaged or of a form that OpenCV " + cv::getVersionString() + " cannot load");
  }
  const cv::Mat gray(network.sidecar.height, network.sidecar.width, CV_8UC3, cv::Scalar::all(128));
  const Result<cv::Mat> output = RunNetwork(network, gray);
  if (!output.ok()) return output.error();
  if (std::vector<int>(output->size.p, output->size.p + output->dims) != output_shape) {
    std::string shape;
    for (int i = 0; i < output->dims; ++i)
      shape += (i > 0 ? "x" : "") + std::to_string(output->size[i]);
    return error(ErrorCode::kInvalidInput,
                 "gives an output of " + shape + ", which its sidecar does not explain");
  }
  return network;
}

Result<cv::Mat> RunNetwork(Network& network, const cv::Mat& image) {
  try {
    const NetworkSidecar& s = network.sidecar;
    network.net.setInput(
        cv::dnn::blobFromImage(image, s.scale, {s.width, s.height}, s.mean, s.swap_rb, false));
    return network.net.forward();
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kCorrupt, "the network '" + network.onnx_file.string() +
                                          "' fails to run: " + exception.what()};
  }
}

}  // namespace plumbline
