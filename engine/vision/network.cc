// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/network.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/files.h"
#include "engine/vision/onnx_file.h"
#include "engine/vision/onnx_for_opencv.h"

namespace plumbline {

namespace {

/// Of what OpenCV says when it gives up (".. Node [TopK@ai.onnx]: ..").
std::string WhyNotLoaded(const std::string& complaint) {
  const std::string opencv = "OpenCV " + cv::getVersionString(), mark = "Node [";
  const std::size_t found = complaint.find(mark), start = found + mark.size();
  const std::size_t end = found == std::string::npos ? found : complaint.find('@', start);
  if (end == std::string::npos)
    return "is damaged or of a form that " + opencv + " cannot load; export it again";
  return "has an operation " + complaint.substr(start, end - start) + " that " + opencv +
         " cannot run; export it with a fixed input size, simplified and without what chooses "
         "boxes at its end (for Ultralytics: dynamic=False, simplify=True, nms=False)";
}

}  // namespace

Result<Network> MakeNetwork(std::string_view onnx_bytes, NetworkSidecar sidecar, std::string name,
                            std::string content_hash) {
  Network network{{}, {}, std::move(sidecar), std::move(name), std::move(content_hash)};
  // What is wrong comes as an exception too.
  const auto level = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  std::optional<std::string> complaint;
  try {
    network.net = cv::dnn::readNetFromONNX(onnx_bytes.data(), onnx_bytes.size());
    network.net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network.net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    network.outputs = network.net.getUnconnectedOutLayersNames();
  } catch (const std::exception& exception) {
    complaint = exception.what();
  }
  cv::utils::logging::setLogLevel(level);
  if (complaint) {
    return Error{ErrorCode::kCorrupt,
                 "the network '" + network.name + "' " + WhyNotLoaded(*complaint)};
  }
  return network;
}

Result<Network> LoadNetwork(const std::filesystem::path& onnx_file, NetworkSidecar sidecar) {
  const Result<OnnxFile> onnx = ReadOnnxFile(onnx_file);
  if (!onnx.ok()) return onnx.error();
  const std::string sidecar_hash = HashHex(SidecarToJson(sidecar).dump());
  std::optional<cv::Size> input;
  if (sidecar.width > 0) input.emplace(sidecar.width, sidecar.height);
  return MakeNetwork(OnnxForOpenCv(onnx->bytes, input), std::move(sidecar), onnx_file.string(),
                     onnx->content_hash + sidecar_hash);
}

Result<Network> LoadNetwork(const std::filesystem::path& onnx_file) {
  Result<NetworkSidecar> sidecar = ReadNetworkSidecar(onnx_file);
  if (!sidecar.ok()) return sidecar.error();
  return LoadNetwork(onnx_file, std::move(sidecar).value());
}

Result<std::string> HashOfNetwork(const std::filesystem::path& onnx_file) {
  const Result<NetworkSidecar> sidecar = ReadNetworkSidecar(onnx_file);
  if (!sidecar.ok()) return sidecar.error();
  std::string hashes = HashHex(SidecarToJson(*sidecar).dump());
  std::vector<std::filesystem::path> networks = {onnx_file};
  const auto head = std::filesystem::path(onnx_file).replace_extension(".head.onnx");
  std::error_code none;
  if (std::filesystem::exists(head, none)) networks.push_back(head);
  for (const std::filesystem::path& network : networks) {
    const Result<std::string> hash = HashFile(network);
    if (!hash.ok()) return hash.error();
    hashes += *hash;
  }
  return HashHex(hashes);
}

FittedImage FitImage(const cv::Mat& image, const NetworkSidecar& sidecar) {
  FittedImage fitted;
  fitted.original = image.size();
  const cv::Size size(sidecar.width, sidecar.height);
  if (sidecar.fit == ImageFit::kStretch) {
    cv::resize(image, fitted.image, size, 0, 0, cv::INTER_LINEAR);
    fitted.scale_x = static_cast<double>(size.width) / image.cols;
    fitted.scale_y = static_cast<double>(size.height) / image.rows;
    return fitted;
  }
  const double scale = std::min(static_cast<double>(size.width) / image.cols,
                                static_cast<double>(size.height) / image.rows);
  const cv::Size inner(std::clamp(static_cast<int>(image.cols * scale), 1, size.width),
                       std::clamp(static_cast<int>(image.rows * scale), 1, size.height));
  const bool centred = sidecar.fit == ImageFit::kCentred;
  const int left = centred ? (size.width - inner.width) / 2 : 0;
  const int top = centred ? (size.height - inner.height) / 2 : 0;
  cv::Mat small;
  cv::resize(image, small, inner, 0, 0, cv::INTER_LINEAR);
  cv::copyMakeBorder(small, fitted.image, top, size.height - inner.height - top, left,
                     size.width - inner.width - left, cv::BORDER_CONSTANT,
                     cv::Scalar::all(sidecar.padding));
  fitted.scale_x = static_cast<double>(inner.width) / image.cols;
  fitted.scale_y = static_cast<double>(inner.height) / image.rows;
  fitted.offset_x = left;
  fitted.offset_y = top;
  return fitted;
}

cv::Mat NetworkInput(const cv::Mat& image, const NetworkSidecar& s) {
  cv::Mat input = cv::dnn::blobFromImage(image, s.scale, image.size(), s.mean, s.swap_rb, false);
  if (s.deviation != cv::Scalar(1, 1, 1, 1)) {
    for (int channel = 0; channel < 3; ++channel) {
      cv::Mat plane(image.size(), CV_32FC1, input.ptr<float>(0, channel));
      plane *= 1 / s.deviation[channel];
    }
  }
  return input;
}

Result<std::vector<cv::Mat>> RunNetworkOn(Network& network, const cv::Mat& input) {
  try {
    network.net.setInput(input);
    std::vector<cv::Mat> outputs;
    network.net.forward(outputs, network.outputs);
    return outputs;
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kCorrupt,
                 "the network '" + network.name + "' fails to run: " + exception.what()};
  }
}

Result<std::vector<cv::Mat>> RunNetwork(Network& network, const cv::Mat& input) {
  return RunNetworkOn(network, NetworkInput(input, network.sidecar));
}

std::string ShapesText(const std::vector<cv::Mat>& outputs) {
  std::string text;
  for (const cv::Mat& output : outputs) {
    if (!text.empty()) text += ", ";
    for (int i = 0; i < output.dims; ++i)
      text += (i > 0 ? "x" : "") + std::to_string(output.size[i]);
  }
  return text;
}

}  // namespace plumbline
