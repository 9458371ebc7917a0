// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>
#include <opencv2/core.hpp>

#include "engine/base/options.h"
#include "engine/base/result.h"
#include "engine/vision/two_stage_sidecar.h"

namespace plumbline {

/// What a network's outputs mean (docs/formats.md). All but kEdge are detectors.
enum class NetworkKind {
  kEdge,
  kFastestDet,
  kYolox,
  kYolov5,
  kYolov8,
  kYolov10,
  kPicodet,
  kNanodet,
  kSsd,
  kTwoStage
};
template <>
struct EnumNames<NetworkKind> {
  static constexpr std::string_view names[] = {"edge",   "fastestdet", "yolox",   "yolov5",
                                               "yolov8", "yolov10",    "picodet", "nanodet",
                                               "ssd",    "two_stage"};
};
std::string_view NameOf(NetworkKind kind);

/// How an image of any size becomes the network's input.
enum class ImageFit {
  kStretch,    ///< To the input's size, whatever its proportions.
  kLetterbox,  ///< Proportions kept, in the upper left corner.
  kCentred,    ///< Proportions kept, in the middle.
};
template <>
struct EnumNames<ImageFit> {
  static constexpr std::string_view names[] = {"stretch", "letterbox", "letterbox_centred"};
};

/// What FILE.json says about the network FILE.onnx beside it (docs/formats.md).
struct NetworkSidecar {
  NetworkKind kind = NetworkKind::kEdge;
  int width = 0, height = 0;  ///< Of the network's input [px]; 0 with multiple_of.
  /// Edge networks only: the network runs at the image's own size, extended to a multiple of this
  /// [px]; 0: always at width x height.
  int multiple_of = 0;
  int shrink = 1;  ///< Edge networks only: the image is made this many times smaller first.
  ImageFit fit = ImageFit::kStretch;
  double padding = 114;  ///< What a letterbox is filled with, in grey levels.
  cv::Scalar mean;  ///< Subtracted first, in the order of the image's channels (after any swap).
  cv::Scalar deviation = {1, 1, 1, 1};  ///< Divided by then, in the same order.
  double scale = 1;                     ///< Multiplied then.
  bool swap_rb = false;                 ///< Whether the network wants RGB.
  std::vector<int> strides;  ///< [px of the input] of the levels; those usual for `kind`.
  /// By the network's index, named as COCO names them (CategoryName); detectors only.
  std::vector<std::string> categories;
  /// (raw output, probability), both rising in [0, 1]; empty where the network's makers give none.
  std::vector<std::pair<float, float>> calibration;
  TwoStageSettings two_stage;  ///< Two-stage networks only.
};

/// Errors: kNotFound (no network, no sidecar), kCorrupt, kInvalidInput (a key missing or
/// senseless), kUnsupported (unknown kind).
Result<NetworkSidecar> ReadNetworkSidecar(const std::filesystem::path& onnx_file);

/// The same of a text; what is wrong is said without a file. Errors: kInvalidInput, kUnsupported.
Result<NetworkSidecar> SidecarFromJson(const nlohmann::json& json);
nlohmann::json SidecarToJson(const NetworkSidecar& sidecar);

}  // namespace plumbline
