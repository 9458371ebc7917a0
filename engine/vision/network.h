// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>

#include "engine/base/result.h"
#include "engine/vision/network_sidecar.h"

namespace plumbline {

/// A network ready to run on the CPU, and what its sidecar says.
struct Network {
  cv::dnn::Net net;
  std::vector<std::string> outputs;  ///< Their names.
  NetworkSidecar sidecar;
  std::string name;          ///< For messages: its file, or what is built in.
  std::string content_hash;  ///< Of network and sidecar.
};

/// Loads FILE.onnx with its sidecar. Errors: kNotFound, kCorrupt, kInvalidInput, kUnsupported.
Result<Network> LoadNetwork(const std::filesystem::path& onnx_file);

/// The same with a sidecar that need not lie beside it.
Result<Network> LoadNetwork(const std::filesystem::path& onnx_file, NetworkSidecar sidecar);

/// The same as long as the network, what its sidecar says (however it is written) and, of a
/// two-stage detector, its head are the same, wherever they lie. Errors: those of the sidecar, kIo.
Result<std::string> HashOfNetwork(const std::filesystem::path& onnx_file);

/// Of bytes as OpenCV can load them. Errors: kCorrupt.
Result<Network> MakeNetwork(std::string_view onnx_bytes, NetworkSidecar sidecar, std::string name,
                            std::string content_hash);

/// An image as a network wants it. With image coordinates in which the image spans [0, width] x [0,
/// height], and shares of the network's input: input = (image * scale + offset) / size.
struct FittedImage {
  cv::Mat image;                      ///< CV_8UC3, of the size of the network's input.
  double scale_x = 1, scale_y = 1;    ///< [px of the input per px of the image]
  double offset_x = 0, offset_y = 0;  ///< [px of the input]
  cv::Size original;
};
FittedImage FitImage(const cv::Mat& image, const NetworkSidecar& sidecar);

/// What a network is fed for an image of its size: 1 x 3 x height x width, normalised.
cv::Mat NetworkInput(const cv::Mat& image, const NetworkSidecar& sidecar);

/// All outputs for any input, valid until the network runs again. Errors: kCorrupt.
Result<std::vector<cv::Mat>> RunNetworkOn(Network& network, const cv::Mat& input);

/// All outputs for an image of the network's size, in the order of `outputs`. Same input, same
/// output, whatever the number of threads. Errors: kCorrupt where OpenCV gives up.
Result<std::vector<cv::Mat>> RunNetwork(Network& network, const cv::Mat& input);

/// "1x85x22x22, 1x2"
std::string ShapesText(const std::vector<cv::Mat>& outputs);

}  // namespace plumbline
