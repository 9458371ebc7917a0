// SPDX-License-Identifier: Apache-2.0
// Networks: the sidecar, our surgery on ONNX files, what is kept of their outputs.
#include <array>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/vision/exporter_notes.h"
#include "engine/vision/network_cache.h"
#include "engine/vision/network_sidecar.h"
#include "engine/vision/onnx_file.h"
#include "engine/vision/onnx_for_opencv.h"
#include "tests/fuzz/fuzz_targets.h"

namespace plumbline::fuzz {
namespace {

Status Sidecar(std::string_view input) {
  const auto json = ReadJson(FileOf("network.json", input));
  if (!json.ok()) return json.error();
  const auto sidecar = SidecarFromJson(*json);
  if (!sidecar.ok()) return sidecar.error();
  return StatusOf(SidecarFromJson(SidecarToJson(*sidecar)));  // what is written is read again
}

/// Without OpenCV's importer, which is handed the result.
Status Onnx(std::string_view input) {
  const auto onnx = ReadOnnxFile(FileOf("network.onnx", input));
  if (!onnx.ok()) return onnx.error();
  (void)NotedNames(*onnx);
  (void)NotedSize(*onnx);
  (void)OnnxForOpenCv(onnx->bytes, std::nullopt);
  (void)OnnxForOpenCv(onnx->bytes, cv::Size(64, 64));
  return {};
}

const Error kNotOurs{ErrorCode::kCorrupt, "the cache holds something else"};

Status CachedEdges(std::string_view input) {
  return DecodeEdges(input).has_value() ? Status() : kNotOurs;
}

Status CachedTensors(std::string_view input) {
  return DecodeTensors(input).has_value() ? Status() : kNotOurs;
}

constexpr std::array kVisionTargets = {Target{"network_sidecar", Sidecar}, Target{"onnx", Onnx},
                                       Target{"cached_edges", CachedEdges},
                                       Target{"cached_tensors", CachedTensors}};

}  // namespace

std::span<const Target> VisionTargets() { return kVisionTargets; }

}  // namespace plumbline::fuzz
