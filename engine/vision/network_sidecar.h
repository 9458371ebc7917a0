// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>

#include "engine/base/result.h"

namespace plumbline {

enum class NetworkKind { kEdge, kFastestDet, kTwoStage };

/// What FILE.json says about the network FILE.onnx beside it (docs/formats.md).
struct NetworkSidecar {
  NetworkKind kind = NetworkKind::kEdge;
  int width = 0, height = 0;  ///< Of the network's input [px].
  cv::Scalar mean;   ///< Subtracted first, in the order of the image's channels (after any swap).
  double scale = 1;  ///< Multiplied then.
  bool swap_rb = false;                 ///< Whether the network wants RGB.
  std::vector<std::string> categories;  ///< COCO names by the network's index; detectors only.
  /// (raw output, probability), both rising in [0, 1]; empty where the network's makers give none.
  std::vector<std::pair<float, float>> calibration;
};

/// Errors: kNotFound (no network, no sidecar), kCorrupt, kInvalidInput (a key missing or
/// senseless), kUnsupported (unknown kind).
Result<NetworkSidecar> ReadNetworkSidecar(const std::filesystem::path& onnx_file);

/// A network ready to run on the CPU, and what its sidecar says.
struct Network {
  cv::dnn::Net net;
  NetworkSidecar sidecar;
  std::filesystem::path onnx_file;
  std::string content_hash;  ///< Of network and sidecar.
};

/// Loads FILE.onnx with its sidecar, checks that it is of `kind`, runs it once on a grey image and
/// checks the shape of the output. Errors: kNotFound, kCorrupt, kInvalidInput, kUnsupported.
Result<Network> LoadNetwork(const std::filesystem::path& onnx_file, NetworkKind kind,
                            const std::vector<int>& output_shape);

/// The output for an image of any size, resized straight to the network's input. Same input, same
/// output, whatever the number of threads. Errors: kCorrupt where OpenCV gives up.
Result<cv::Mat> RunNetwork(Network& network, const cv::Mat& image);

}  // namespace plumbline
