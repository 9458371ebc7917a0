// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <span>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "app/verbs/boxes_picture.h"
#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/base/timer.h"
#include "engine/sensor/image_file.h"
#include "engine/vision/detector.h"
#include "engine/vision/edge_network.h"
#include "engine/vision/fetched_networks.h"
#include "engine/vision/network_guess.h"
#include "engine/vision/network_sidecar.h"

namespace plumbline {
namespace {

struct NetworkCheckArguments {
  std::string network, image, out_file, categories_file;
  bool write = false;
  float min_score = 0.3f;
};

Status ListNetworks() {
  std::cout << "built in:\n"
               "  builtin         edges; what --edges is where a sequence has none\n"
               "  builtin-half    edges, by one half as wide: two to three times as fast\n"
               "  gradient        edges from image gradients, no network: the fastest\n"
               "  builtin         boxes of furniture; what --detector is where a sequence has none "
               "and nothing better was fetched before\n"
               "to fetch with 'plumbline networks get NAME' (detectors; "
            << NetworksFolder().string() << "):\n";
  for (const ListedNetwork& network : ListedNetworks()) {
    const bool here = FetchedNetwork(network.name).has_value();
    std::cout << "  " << network.name
              << std::string(16 - std::min<std::size_t>(15, network.name.size()), ' ')
              << network.about << (here ? "; fetched" : "") << "\n"
              << std::string(18, ' ') << network.licence << "\n";
  }
  std::cout << "your own: FILE.onnx; 'plumbline networks check FILE.onnx' says what it is\n";
  return {};
}

Status GetNetwork(const std::string& name) {
  const auto& list = ListedNetworks();
  const auto found = std::find_if(
      list.begin(), list.end(), [&](const ListedNetwork& network) { return network.name == name; });
  if (found == list.end()) {
    std::string names;
    for (const ListedNetwork& network : list) names += (names.empty() ? "" : ", ") + network.name;
    return Error{ErrorCode::kInvalidInput,
                 "there is no network '" + name + "' to fetch; the list has " + names};
  }
  ConsoleWork console;
  const Result<std::filesystem::path> file =
      FetchNetwork(*found, NetworksFolder(), console.context());
  if (!file.ok()) return file.error();
  std::cout << found->name << " is at " << file->string() << " (" << found->licence
            << "); runs without boxes of their own use it, and --detector " << found->name
            << " names it" << std::endl;
  return {};
}

Result<std::vector<std::string>> ReadNames(const std::string& file) {
  std::vector<std::string> names;
  if (file.empty()) return names;
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  std::string line;
  for (const char c : *text + "\n") {
    if (c != '\n') {
      if (c != '\r') line.push_back(c);
      continue;
    }
    if (!line.empty()) names.push_back(line);
    line.clear();
  }
  if (names.empty())
    return Error{ErrorCode::kInvalidInput, "'" + file + "' names no category; write one a line"};
  return names;
}

void PrintFeeding(const NetworkSidecar& s) {
  const auto three = [](const cv::Scalar& v) {
    char text[64];
    std::snprintf(text, sizeof(text), "%.6g %.6g %.6g", v[0], v[1], v[2]);
    return std::string(text);
  };
  std::cout << "  input       ";
  if (s.multiple_of > 0) {
    std::cout << "any size, extended to a multiple of " << s.multiple_of;
  } else {
    std::cout << s.width << "x" << s.height << ", "
              << EnumNames<ImageFit>::names[static_cast<std::size_t>(s.fit)];
  }
  std::cout << ", " << (s.swap_rb ? "RGB" : "BGR") << ", (value - " << three(s.mean) << ") / "
            << three(s.deviation) << " * " << s.scale << "\n";
  if (s.kind == NetworkKind::kEdge) return;
  std::cout << "  categories  " << s.categories.size() << ":";
  for (std::size_t i = 0; i < s.categories.size() && i < 8; ++i)
    std::cout << (i == 0 ? " " : ", ") << s.categories[i];
  std::cout << (s.categories.size() > 8 ? ", ..\n" : "\n");
}

/// Milliseconds that `run` takes, the least of three.
template <typename Run>
double LeastMilliseconds(const Run& run) {
  double least = 1e9;
  for (int i = 0; i < 3; ++i) {
    Stopwatch watch;
    run();
    least = std::min(least, watch.Lap());
  }
  return least;
}

/// What the network finds, printed and drawn into `picture`.
Status CheckDetector(const NetworkCheckArguments& arguments, const NetworkSidecar& sidecar,
                     const Frame& frame, cv::Mat& picture) {
  const auto detector = CreateNetworkDetector(arguments.network, sidecar,
                                              {.min_score = arguments.min_score, .cache = false});
  if (!detector.ok()) return detector.error();
  const auto found = detector.value()->Detect(frame);
  if (!found.ok()) return found.error();
  std::printf("  time        %.0f ms an image on this machine\n",
              LeastMilliseconds([&] { static_cast<void>(detector.value()->Detect(frame)); }));
  if (arguments.image.empty()) return {};
  const std::span<const Detection> boxes = found.value()->proposals();
  std::printf("  boxes       %zu that score %g or more: x0 y0 x1 y1 [px]\n", boxes.size(),
              static_cast<double>(arguments.min_score));
  for (const auto& [box, category, score] : boxes) {
    std::printf("    %.3f  %-14s %7.1f %7.1f %7.1f %7.1f\n", static_cast<double>(score),
                category.c_str(), static_cast<double>(box.x0), static_cast<double>(box.y0),
                static_cast<double>(box.x1), static_cast<double>(box.y1));
  }
  DrawBoxes(boxes, picture);
  return {};
}

Status CheckEdges(const NetworkCheckArguments& arguments, const NetworkSidecar& sidecar,
                  const Frame& frame, cv::Mat& picture) {
  Result<Network> network = LoadNetwork(arguments.network, sidecar);
  if (!network.ok()) return network.error();
  const auto edges = CreateEdgeNetwork(std::move(network).value(), {.cache = false});
  if (!edges.ok()) return edges.error();
  const Result<EdgeMap> map = edges.value()->Detect(frame);
  if (!map.ok()) return map.error();
  std::printf("  time        %.0f ms for %dx%d on this machine, thinning included\n",
              LeastMilliseconds([&] { static_cast<void>(edges.value()->Detect(frame)); }),
              frame.image.cols, frame.image.rows);
  cv::cvtColor(255 - map->probability, picture, cv::COLOR_GRAY2BGR);
  return {};
}

/// What the sidecar says, or what the file looks like where it has none or names are given.
Result<NetworkSidecar> SidecarOf(const std::filesystem::path& file,
                                 const std::vector<std::string>& names) {
  std::error_code none;
  if (names.empty() &&
      std::filesystem::exists(std::filesystem::path(file).replace_extension(".json"), none)) {
    Result<NetworkSidecar> sidecar = ReadNetworkSidecar(file);
    if (sidecar.ok())
      std::cout << file.string() << ": " << NameOf(sidecar->kind) << ", as its sidecar says\n";
    return sidecar;
  }
  const Result<NetworkGuess> guess = GuessSidecar(file, names);
  if (!guess.ok()) return guess.error();
  std::cout << file.string() << ": " << NameOf(guess->sidecar.kind) << ", a guess\n";
  for (const std::string& reason : guess->reasons) std::cout << "  because     " << reason << "\n";
  return guess->sidecar;
}

Status CheckNetwork(const NetworkCheckArguments& arguments) {
  const std::filesystem::path file = arguments.network;
  Frame frame;
  frame.image = cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(128));
  if (!arguments.image.empty()) {
    Result<cv::Mat> image = ReadImage(arguments.image, ImageKind::kColor);
    if (!image.ok()) return image.error();
    frame.image = std::move(image).value();
  }
  const Result<std::vector<std::string>> names = ReadNames(arguments.categories_file);
  if (!names.ok()) return names.error();
  const Result<NetworkSidecar> sidecar = SidecarOf(file, *names);
  if (!sidecar.ok()) return sidecar.error();
  PrintFeeding(*sidecar);
  std::cout << std::flush;
  cv::Mat picture = frame.image.clone();
  Status status = sidecar->kind == NetworkKind::kEdge
                      ? CheckEdges(arguments, *sidecar, frame, picture)
                      : CheckDetector(arguments, *sidecar, frame, picture);
  std::fflush(stdout);
  if (!status.ok()) return status;
  if (!arguments.out_file.empty()) {
    std::vector<unsigned char> bytes;
    cv::imencode(".png", picture, bytes);
    status = WriteFileAtomically(arguments.out_file,
                                 {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (!status.ok()) return status;
    std::cout << "  picture     " << arguments.out_file << "\n";
  }
  const auto sidecar_file = std::filesystem::path(file).replace_extension(".json");
  if (arguments.write) {
    status = WriteJson(sidecar_file, SidecarToJson(*sidecar));
    if (status.ok()) std::cout << "  sidecar     " << sidecar_file.string() << " written\n";
  } else if (std::error_code none; !std::filesystem::exists(sidecar_file, none)) {
    std::cout << "Look at the picture (--out FILE.png), then add --write to keep this as "
              << sidecar_file.string() << "; correct it there.\n";
  }
  return status;
}

}  // namespace

void AddNetworksVerb(CLI::App& app, VerbFunction& chosen) {
  CLI::App* verb = app.add_subcommand(
      "networks", "The networks that find edges and objects: built in, to fetch, your own");
  verb->require_subcommand(1);
  verb->add_subcommand("list", "Which networks there are")->callback([&chosen] {
    chosen = ListNetworks;
  });

  auto name = std::make_shared<std::string>();
  CLI::App* get = verb->add_subcommand(
      "get",
      "Fetch a public network (https; its SHA-256 is checked; goes on where it was cut off)");
  get->add_option("name", *name, "As 'plumbline networks list' has it")->required();
  get->callback([name, &chosen] { chosen = [name] { return GetNetwork(*name); }; });

  auto arguments = std::make_shared<NetworkCheckArguments>();
  CLI::App* check = verb->add_subcommand(
      "check", "Say what a network is, run it on an image and draw what it finds");
  check->add_option("network", arguments->network, "An ONNX network, with or without a sidecar")
      ->required()
      ->type_name("FILE.onnx");
  check->add_option("image", arguments->image, "An image to try it on");
  check->add_option("--out", arguments->out_file, "Write the image with the boxes, or the edges")
      ->type_name("FILE.png");
  check
      ->add_option("--categories", arguments->categories_file,
                   "Names of its categories in its order, one a line")
      ->type_name("FILE");
  check->add_option("--min-score", arguments->min_score, "Leave out boxes that score less")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  check->add_flag("--write", arguments->write,
                  "Write the sidecar FILE.json, so that --detector and --edges take the network");
  check->callback(
      [arguments, &chosen] { chosen = [arguments] { return CheckNetwork(*arguments); }; });
}

}  // namespace plumbline
