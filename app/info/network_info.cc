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

std::string TitleOf(NetworkKind kind) {
  return kind == NetworkKind::kEdge ? "edge network"
                                    : "detector (" + std::string(NameOf(kind)) + ")";
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
  info.title = TitleOf(network.kind);
  const std::string size = network.multiple_of > 0
                               ? Format("any size, a multiple of %d", network.multiple_of)
                               : Format("%dx%d", network.width, network.height);
  info.lines.push_back({"Input", size + (network.swap_rb ? ", RGB" : ", BGR")});
  if (!network.categories.empty())
    info.lines.push_back({"Categories", std::to_string(network.categories.size())});
  info.json["network"] = {{"kind", NameOf(network.kind)},
                          {"width", network.width},
                          {"height", network.height},
                          {"categories", network.categories}};
  if (network.kind == NetworkKind::kEdge) {
    info.json["network"]["calibrated"] = !network.calibration.empty();
    if (network.calibration.empty())
      info.odd.push_back(
          "Its sidecar has no calibration: that of a network with balanced classes is used.");
  }
  const Status runs = TryNetwork(path, network.kind);
  info.json["usable"] = runs.ok();
  info.lines.push_back({"Runs", runs.ok() ? "yes" : "no"});
  if (!runs.ok()) info.odd.push_back(runs.error().message);
  return info;
}

}  // namespace plumbline
