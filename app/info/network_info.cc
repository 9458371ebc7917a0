// SPDX-License-Identifier: Apache-2.0
#include "app/info/info_text.h"
#include "app/info/path_info.h"
#include "engine/vision/detector.h"
#include "engine/vision/edge_detector.h"
#include "engine/vision/network_sidecar.h"

namespace plumbline {
namespace {

/// Runs it once on a grey image.
Status TryNetwork(const std::filesystem::path& path, NetworkKind kind) {
  if (kind == NetworkKind::kEdge) {
    const auto edges = CreateEdgeDetector(path.string(), nullptr);
    return edges.ok() ? Status() : Status(edges.error());
  }
  const auto detector = CreateDetector(path.string(), nullptr);
  return detector.ok() ? Status() : Status(detector.error());
}

const char* NameOf(NetworkKind kind) {
  switch (kind) {
    case NetworkKind::kEdge:
      return "edge network";
    case NetworkKind::kFastestDet:
      return "detector (fastestdet)";
    case NetworkKind::kTwoStage:
      return "two-stage detector";
  }
  return "";
}

}  // namespace

Likeness ProbeNetwork(const std::filesystem::path& path) {
  return HasEnding(path, ".onnx") ? Likeness::kCertain : Likeness::kNone;
}

Result<PathInfo> DescribeNetwork(const std::filesystem::path& path) {
  const Result<NetworkSidecar> sidecar = ReadNetworkSidecar(path);
  PathInfo info;
  info.title = "network";
  info.json["usable"] = false;
  if (!sidecar.ok()) {
    info.odd.push_back(sidecar.error().message);
    return info;
  }
  const NetworkSidecar& network = sidecar.value();
  info.title = NameOf(network.kind);
  info.lines.push_back({"Input", Format("%dx%d, %s", network.width, network.height,
                                        network.swap_rb ? "RGB" : "BGR")});
  if (!network.categories.empty())
    info.lines.push_back({"Categories", std::to_string(network.categories.size())});
  info.json["network"] = {{"kind", NameOf(network.kind)},
                          {"width", network.width},
                          {"height", network.height},
                          {"categories", network.categories}};
  if (network.kind == NetworkKind::kEdge) {
    info.json["network"]["calibrated"] = !network.calibration.empty();
    if (network.calibration.empty())
      info.odd.push_back("Its sidecar has no calibration: raw outputs are taken as probabilities.");
  }
  const Status runs = TryNetwork(path, network.kind);
  info.json["usable"] = runs.ok();
  info.lines.push_back({"Runs", runs.ok() ? "yes" : "no"});
  if (!runs.ok()) info.odd.push_back(runs.error().message);
  return info;
}

}  // namespace plumbline
