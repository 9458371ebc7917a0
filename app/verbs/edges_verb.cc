// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <memory>

#include <opencv2/imgcodecs.hpp>

#include "app/verbs/image_arguments.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/vision/edge_detector.h"

namespace plumbline {
namespace {

struct EdgesArguments {
  std::vector<std::string> images;
  std::string out_folder;
  std::string network = "builtin";
  bool raw = false;
};

Status WritePng(const std::filesystem::path& file, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", image, bytes);
  return WriteFileAtomically(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

Status Edges(const EdgesArguments& arguments) {
  const auto images = ExpandImages(arguments.images);
  if (!images.ok()) return images.error();
  const Result<std::unique_ptr<EdgeDetector>> detector =
      CreateEdgeDetector(arguments.network, nullptr, {.calibrate = !arguments.raw});
  if (!detector.ok()) return detector.error();
  const std::filesystem::path folder = arguments.out_folder;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return Error{ErrorCode::kIo,
                 "cannot make the folder '" + folder.string() + "': " + error.message()};
  return ForEachImage(*images, "finding edges", [&](const NamedImage& image) {
    Frame frame;
    frame.image = image.image;
    const Result<EdgeMap> edges = detector.value()->Detect(frame);
    if (!edges.ok()) return Status(edges.error());
    const Status written = WritePng(folder / (image.stem + "_angle.png"), edges->angle);
    return written.ok() ? WritePng(folder / (image.stem + ".png"), edges->probability) : written;
  });
}

}  // namespace

void AddEdgesVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<EdgesArguments>();
  CLI::App* verb =
      app.add_subcommand("edges", "Find edges in images and write their probability and direction");
  verb->add_option("images", arguments->images, "Images, videos, or folders of images")
      ->required()
      ->type_name("IMAGES");
  verb->add_option(
          "--out", arguments->out_folder,
          "Write NNN.png (probability of an edge, 255 = certain, one-pixel lines) and "
          "NNN_angle.png "
          "(direction of its normal, 0 to pi as 0 to 256), as a sequence's edges/ wants them")
      ->required()
      ->type_name("DIR");
  verb->add_option("--network", arguments->network,
                   "builtin (our network), builtin-half (half as wide, two to three times as "
                   "fast), gradient "
                   "(no network), or FILE.onnx with its sidecar FILE.json beside it")
      ->capture_default_str();
  verb->add_flag("--raw", arguments->raw,
                 "Write raw scores instead of probabilities (to measure a calibration)");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Edges(*arguments); }; });
}

}  // namespace plumbline
