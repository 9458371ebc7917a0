// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/network_process.h"

#include <algorithm>
#include <filesystem>
#include <utility>

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

/// Fills in what `network.file` is.
void Recognise(NetworkFile& network) {
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
    : on_publish_(std::move(on_publish)), listed_(std::move(listed)) {
  for (const ListedNetwork& network : listed_)
    now_.detectors.push_back({network.name, network.about, ""});
}

NetworkProcess::~NetworkProcess() { StopFetching(); }

void NetworkProcess::Look() {
  looking_.Do([this] { LookForFetched(); });
}

void NetworkProcess::LookAt(const std::string& file) {
  looking_.Do([this, file] { Examine(file); });
}

void NetworkProcess::Fetch(const std::string& name) {
  const auto network = std::ranges::find(listed_, name, &ListedNetwork::name);
  if (network == listed_.end()) return;
  if (stop_fetching_.stop_requested()) stop_fetching_ = {};
  fetching_.Do([this, network, stop = stop_fetching_.get_token()] { Download(*network, stop); });
}

void NetworkProcess::StopFetching() { stop_fetching_.request_stop(); }

void NetworkProcess::LookForFetched() {
  Change([](NetworksView& now) {
    for (ListedDetector& detector : now.detectors) {
      const auto file = NetworksFolder() / (detector.name + ".onnx");
      std::error_code none;
      detector.file = std::filesystem::exists(file, none) ? file.string() : "";
    }
  });
}

void NetworkProcess::Examine(const std::string& file) {
  NetworkFile network{.file = std::filesystem::absolute(file).lexically_normal().string()};
  Change([&](NetworksView& now) { now.file = network; });
  try {
    Recognise(network);
  } catch (const std::exception& error) {
    network.problem = "the network '" + file + "' cannot be used: " + error.what();
  }
  Change([&](NetworksView& now) { now.file = network; });
}

void NetworkProcess::Download(const ListedNetwork& network, const std::stop_token& stop) {
  if (stop.stop_requested()) return;
  const auto tell = [&](const std::string& fetching) {
    ChangeDetector(network.name, [&](ListedDetector& detector) {
      detector.fetching = fetching;
      detector.problem.clear();
    });
  };
  tell("connecting");
  long long told = -1;
  const WorkContext work{[&](const Progress& progress) {
                           const auto percent = 100LL * progress.done / std::max(1, progress.total);
                           if (std::exchange(told, percent) != percent)
                             tell(fmt::format("{} % has arrived", percent));
                         },
                         stop};
  const auto file = FetchNetwork(network, NetworksFolder(), work);
  ChangeDetector(network.name, [&](ListedDetector& detector) {
    detector.fetching.clear();
    if (file.ok()) {
      detector.file = file->string();
    } else if (file.error().code != ErrorCode::kCancelled) {
      detector.problem = file.error().message;
    }
  });
}

void NetworkProcess::Change(const std::function<void(NetworksView&)>& change) {
  {
    const std::lock_guard lock(mutex_);
    change(now_);
    view_.Publish(std::make_shared<const NetworksView>(now_));
  }
  if (on_publish_) on_publish_();
}

void NetworkProcess::ChangeDetector(const std::string& name,
                                    const std::function<void(ListedDetector&)>& change) {
  Change([&](NetworksView& now) {
    change(*std::ranges::find(now.detectors, name, &ListedDetector::name));
  });
}

}  // namespace plumbline
