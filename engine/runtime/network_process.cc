// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/network_process.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "engine/vision/detector.h"
#include "engine/vision/edge_network.h"
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

}  // namespace

NetworkProcess::NetworkProcess(std::function<void()> on_publish, std::vector<ListedNetwork> listed)
    : on_publish_(std::move(on_publish)), listed_(std::move(listed)), thread_([this] { Run(); }) {}

NetworkProcess::~NetworkProcess() {
  StopFetching();
  tasks_.Close();
  if (thread_.joinable()) thread_.join();
}

void NetworkProcess::Look() { tasks_.TryPush(Looking{}); }
void NetworkProcess::LookAt(const std::string& file) { tasks_.TryPush(Looking{file}); }

void NetworkProcess::Fetch(const std::string& name) {
  if (stop_fetching_.stop_requested()) stop_fetching_ = {};
  tasks_.TryPush(Fetching{name, stop_fetching_.get_token()});
}

void NetworkProcess::StopFetching() { stop_fetching_.request_stop(); }

void NetworkProcess::Run() {
  for (const ListedNetwork& network : listed_)
    now_.detectors.push_back({network.name, network.about, ""});
  while (const auto task = tasks_.Pop()) {
    for (ListedDetector& detector : now_.detectors) {
      const auto file = NetworksFolder() / (detector.name + ".onnx");
      std::error_code none;
      detector.file = std::filesystem::exists(file, none) ? file.string() : "";
    }
    std::visit([this](const auto& what) { Do(what); }, *task);
    Publish();
  }
}

void NetworkProcess::Do(const Looking& looking) {
  if (looking.file.empty()) return;
  now_.file = {.file = std::filesystem::absolute(looking.file).lexically_normal().string()};
  Publish();
  try {
    Examine(now_.file);
  } catch (const std::exception& error) {
    now_.file.problem = "the network '" + looking.file + "' cannot be used: " + error.what();
  }
}

void NetworkProcess::Do(const Fetching& fetching) {
  const auto network = std::ranges::find(listed_, fetching.name, &ListedNetwork::name);
  const auto shown = std::ranges::find(now_.detectors, fetching.name, &ListedDetector::name);
  if (network == listed_.end() || fetching.stop.stop_requested()) return;
  shown->problem.clear();
  shown->fetching = "connecting";
  Publish();
  const WorkContext work{[&](const Progress& progress) {
                           const auto text =
                               fmt::format("{} % has arrived",
                                           100LL * progress.done / std::max(1, progress.total));
                           if (std::exchange(shown->fetching, text) != text) Publish();
                         },
                         fetching.stop};
  const auto file = FetchNetwork(*network, NetworksFolder(), work);
  shown->fetching.clear();
  if (file.ok()) {
    shown->file = file->string();
  } else if (file.error().code != ErrorCode::kCancelled) {
    shown->problem = file.error().message;
  }
}

void NetworkProcess::Publish() {
  view_.Publish(std::make_shared<const NetworksView>(now_));
  if (on_publish_) on_publish_();
}

}  // namespace plumbline
