// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/network_process.h"

#include <filesystem>

#include <fmt/format.h>

#include "engine/vision/detector.h"
#include "engine/vision/edge_network.h"
#include "engine/vision/fetched_networks.h"
#include "engine/vision/network_guess.h"

namespace plumbline {
namespace {

std::string Describe(const NetworkSidecar& sidecar) {
  std::string text(NameOf(sidecar.kind));
  if (sidecar.multiple_of > 0)
    text += ", images of any size";
  else
    text += fmt::format(", {} \u00d7 {} px", sidecar.width, sidecar.height);
  if (sidecar.kind != NetworkKind::kEdge)
    text += fmt::format(", {} categories", sidecar.categories.size());
  return text;
}

/// Runs it as a run would.
Status Try(const std::filesystem::path& file, const NetworkSidecar& sidecar) {
  Frame frame;
  frame.image = cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(128));
  if (sidecar.kind == NetworkKind::kEdge) {
    Result<Network> network = LoadNetwork(file, sidecar);
    if (!network.ok()) return network.error();
    const auto edges = CreateEdgeNetwork(std::move(network).value(), {.cache = false});
    if (!edges.ok()) return edges.error();
    const auto found = (*edges)->Detect(frame);
    return found.ok() ? Status() : Status(found.error());
  }
  const auto detector = CreateNetworkDetector(file, sidecar, {.cache = false});
  if (!detector.ok()) return detector.error();
  const auto found = (*detector)->Detect(frame);
  return found.ok() ? Status() : Status(found.error());
}

void Examine(NetworkFile& network) {
  const std::filesystem::path file = network.file;
  network.known = true;
  if (file.extension() != ".onnx") {
    network.problem = "'" + network.file + "' is no ONNX network; give the path of a FILE.onnx";
    return;
  }
  std::error_code none;
  network.guessed =
      std::filesystem::exists(file, none) &&
      !std::filesystem::exists(std::filesystem::path(file).replace_extension(".json"), none);
  NetworkSidecar sidecar;
  if (network.guessed) {
    const Result<NetworkGuess> guess = GuessSidecar(file);
    if (!guess.ok()) return static_cast<void>(network.problem = guess.error().message);
    sidecar = guess->sidecar;
    network.reasons = guess->reasons;
  } else {
    const Result<NetworkSidecar> read = ReadNetworkSidecar(file);
    if (!read.ok()) return static_cast<void>(network.problem = read.error().message);
    sidecar = *read;
  }
  network.edges = sidecar.kind == NetworkKind::kEdge;
  network.what = Describe(sidecar);
  if (const Status status = Try(file, sidecar); !status.ok())
    network.problem = status.error().message;
}

std::vector<ListedDetector> Detectors() {
  std::vector<ListedDetector> detectors;
  for (const ListedNetwork& network : ListedNetworks()) {
    const auto file = FetchedNetwork(network.name);
    detectors.push_back({network.name, network.about, file ? file->string() : ""});
  }
  return detectors;
}

}  // namespace

NetworkProcess::NetworkProcess(std::function<void()> on_publish)
    : on_publish_(std::move(on_publish)), thread_([this] { Run(); }) {}

NetworkProcess::~NetworkProcess() {
  files_.Close();
  if (thread_.joinable()) thread_.join();
}

void NetworkProcess::Look() { files_.TryPush(""); }
void NetworkProcess::LookAt(const std::string& file) { files_.TryPush(file); }

void NetworkProcess::Run() {
  NetworksView view;
  while (const auto file = files_.Pop()) {
    view.detectors = Detectors();
    if (!file->empty()) {
      view.file = {.file = std::filesystem::absolute(*file).lexically_normal().string()};
      Publish(view);
      try {
        Examine(view.file);
      } catch (const std::exception& error) {
        view.file.problem = "the network '" + *file + "' cannot be used: " + error.what();
      }
    }
    Publish(view);
  }
}

void NetworkProcess::Publish(const NetworksView& view) {
  view_.Publish(std::make_shared<const NetworksView>(view));
  if (on_publish_) on_publish_();
}

}  // namespace plumbline
