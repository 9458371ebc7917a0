// SPDX-License-Identifier: Apache-2.0
// Networks: the sidecar, our surgery on ONNX files, what is kept of their outputs.
#include <array>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/vision/exporter_notes.h"
#include "engine/vision/network_cache.h"
#include "engine/vision/network_sidecar.h"
#include "engine/vision/onnx_file.h"
#include "engine/vision/onnx_for_opencv.h"
#include "engine/vision/viewpoint_model.h"
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

/// Without the hash before it, which no mutation would keep; seen from all around.
Status CachedViewpoints(std::string_view input) {
  static const ViewpointModelOptions kOptions{.azimuths = 4, .elevations = 2, .distances = {1, 2}};
  const auto model = ViewpointModel::Decode(input, kOptions);
  if (model == nullptr) return kNotOurs;
  float sum = 0;
  for (const float away : {0.0f, 1.0f, 3.0f}) {
    for (const float x : {-away, away}) {
      for (const float y : {-away, away}) {
        for (const float z : {0.0f, away}) {
          const ContourView view = model->View({x, y, z});
          for (int i = 0; i < view.size; ++i) sum += view.x[i] + view.nz[i];
          PLB_CHECK(view.outline_size >= 0 && view.outline_size <= view.size);
        }
      }
    }
  }
  volatile const float used = sum;
  (void)used;
  return {};
}

constexpr std::array kVisionTargets = {
    Target{"network_sidecar", Sidecar}, Target{"onnx", Onnx}, Target{"cached_edges", CachedEdges},
    Target{"cached_tensors", CachedTensors}, Target{"cached_viewpoints", CachedViewpoints}};

}  // namespace

std::span<const Target> VisionTargets() { return kVisionTargets; }

}  // namespace plumbline::fuzz
