// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/verbs/image_arguments.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/dataset/proposals_file.h"
#include "engine/vision/detector.h"

namespace plumbline {
namespace {

struct DetectArguments {
  std::vector<std::string> images;
  std::string detector;
  std::string json_file;
  std::string out_folder;
  DetectorOptions options;
};

Status Detect(const DetectArguments& arguments) {
  const auto images = ExpandImages(arguments.images);
  if (!images.ok()) return images.error();
  const Result<std::unique_ptr<Detector>> detector =
      CreateDetector(arguments.detector, nullptr, arguments.options);
  if (!detector.ok()) return detector.error();
  if (!arguments.out_folder.empty()) {
    std::error_code error;
    std::filesystem::create_directories(arguments.out_folder, error);
    if (error)
      return Error{ErrorCode::kIo,
                   "cannot make the folder '" + arguments.out_folder + "': " + error.message()};
  }
  nlohmann::json results = nlohmann::json::array();
  const Status status = ForEachImage(
      *images, "detecting", [&](const std::filesystem::path& file, const cv::Mat& image) {
        Frame frame;
        frame.image = image;
        const Result<std::unique_ptr<const FrameDetections>> found =
            detector.value()->Detect(frame);
        if (!found.ok()) return Status(found.error());
        results.push_back(ProposalsToJson(file.string(), found.value()->proposals()));
        if (arguments.out_folder.empty()) return Status();
        const auto target =
            std::filesystem::path(arguments.out_folder) / (file.stem().string() + ".json");
        return WriteJson(target, nlohmann::json::array({results.back()}));
      });
  if (!arguments.json_file.empty()) {
    const Status written = WriteJsonResult(arguments.json_file, results);
    if (!written.ok()) return written;
  }
  return status;
}

}  // namespace

void AddDetectVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<DetectArguments>();
  CLI::App* verb = app.add_subcommand("detect", "Find objects in images and write their boxes");
  verb->add_option("images", arguments->images, "Images, or folders of images")
      ->required()
      ->type_name("IMAGES");
  auto* detector =
      verb->add_option(
              "--detector", arguments->detector,
              "A network, with its sidecar FILE.json beside it; this version comes with none")
          ->type_name("FILE.onnx");
  auto* json =
      verb->add_option(
              "--json", arguments->json_file,
              "Write [{image, boxes: [{x0, y0, x1, y1, category, score}]}] [px] to FILE (- for "
              "standard output)")
          ->type_name("FILE");
  auto* out = verb->add_option("--out", arguments->out_folder,
                               "Write NNN.json per image, as a sequence's proposals/ wants them")
                  ->type_name("DIR");
  verb->add_option("--min-score", arguments->options.min_score, "Leave out boxes that score less")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  verb->add_option("--nms-iou", arguments->options.nms_iou,
                   "Of boxes of one category that overlap more, keep the best")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  verb->callback([arguments, detector, json, out, &chosen] {
    if (detector->count() == 0)
      throw CLI::RequiredError("--detector FILE.onnx (this version comes with no network)");
    if (json->count() + out->count() == 0) throw CLI::RequiredError("--json FILE or --out DIR");
    chosen = [arguments] { return Detect(*arguments); };
  });
}

}  // namespace plumbline
