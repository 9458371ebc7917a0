// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <span>

#include <nlohmann/json.hpp>

#include "app/verbs/image_arguments.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/dataset/proposals_file.h"
#include "engine/vision/category_names.h"
#include "engine/vision/detector.h"
#include "engine/vision/fetched_networks.h"

namespace plumbline {
namespace {

struct DetectArguments {
  std::vector<std::string> images;
  std::string detector;
  std::string json_file, coco_file;
  std::string out_folder;
  DetectorOptions options;
};

/// Boxes as COCO's tools read them: images, categories and annotations with a score each. Corners
/// are counted from the image's upper left edge, not from the centre of its first pixel.
class CocoResult {
 public:
  void Add(const NamedImage& image, std::span<const Detection> boxes) {
    const int id = static_cast<int>(images_.size()) + 1;
    images_.push_back({{"id", id},
                       {"file_name", image.name},
                       {"width", image.image.cols},
                       {"height", image.image.rows}});
    for (const auto& [box, category, score] : boxes) {
      const float width = box.x1 - box.x0, height = box.y1 - box.y0;
      annotations_.push_back({{"id", annotations_.size() + 1},
                              {"image_id", id},
                              {"category_id", NumberOf(category)},
                              {"bbox", {box.x0 + 0.5f, box.y0 + 0.5f, width, height}},
                              {"area", width * height},
                              {"iscrowd", 0},
                              {"score", score}});
    }
  }
  nlohmann::json ToJson() const {
    nlohmann::json categories = nlohmann::json::array();
    for (const auto& [name, number] : numbers_)
      categories.push_back({{"id", number}, {"name", name}});
    return {{"images", images_}, {"categories", categories}, {"annotations", annotations_}};
  }

 private:
  int NumberOf(const std::string& category) {
    const int next = kFirstNumberBeyondCoco + static_cast<int>(numbers_.size());
    return numbers_.try_emplace(category, CocoNumber(category).value_or(next)).first->second;
  }

  nlohmann::json images_ = nlohmann::json::array(), annotations_ = nlohmann::json::array();
  std::map<std::string, int> numbers_;
};

Result<std::unique_ptr<Detector>> ChooseDetector(const DetectArguments& arguments) {
  if (arguments.detector.empty()) {
    const auto best = BestFetchedDetector();
    if (best) return CreateDetector(best->string(), nullptr, arguments.options);
    return CreateDetector("builtin", nullptr, arguments.options);
  }
  const Result<std::string> choice = ResolveNetworkName(arguments.detector);
  if (!choice.ok()) return choice.error();
  return CreateDetector(*choice, nullptr, arguments.options);
}

Status Detect(const DetectArguments& arguments) {
  const auto images = ExpandImages(arguments.images);
  if (!images.ok()) return images.error();
  const Result<std::unique_ptr<Detector>> detector = ChooseDetector(arguments);
  if (!detector.ok()) return detector.error();
  if (!arguments.out_folder.empty()) {
    std::error_code error;
    std::filesystem::create_directories(arguments.out_folder, error);
    if (error)
      return Error{ErrorCode::kIo,
                   "cannot make the folder '" + arguments.out_folder + "': " + error.message()};
  }
  nlohmann::json results = nlohmann::json::array();
  CocoResult coco;
  const Status status = ForEachImage(*images, "detecting", [&](const NamedImage& image) {
    Frame frame;
    frame.image = image.image;
    const Result<std::unique_ptr<const FrameDetections>> found = detector.value()->Detect(frame);
    if (!found.ok()) return Status(found.error());
    results.push_back(ProposalsToJson(image.name, found.value()->proposals()));
    coco.Add(image, found.value()->proposals());
    if (arguments.out_folder.empty()) return Status();
    const auto target = std::filesystem::path(arguments.out_folder) / (image.stem + ".json");
    return WriteJson(target, nlohmann::json::array({results.back()}));
  });
  if (!arguments.json_file.empty()) {
    const Status written = WriteJsonResult(arguments.json_file, results);
    if (!written.ok()) return written;
  }
  if (!arguments.coco_file.empty()) {
    const Status written = WriteJsonResult(arguments.coco_file, coco.ToJson());
    if (!written.ok()) return written;
  }
  return status;
}

}  // namespace

void AddDetectVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<DetectArguments>();
  CLI::App* verb = app.add_subcommand("detect", "Find objects in images and write their boxes");
  verb->add_option("images", arguments->images, "Images, videos, or folders of images")
      ->required()
      ->type_name("IMAGES");
  verb->add_option("--detector", arguments->detector,
                   "builtin (our network), one that 'plumbline networks get' has fetched, or "
                   "FILE.onnx with its sidecar FILE.json beside it (default: the best that was "
                   "fetched, else builtin)");
  auto* json =
      verb->add_option(
              "--json", arguments->json_file,
              "Write [{image, boxes: [{x0, y0, x1, y1, category, score}]}] [px] to FILE (- for "
              "standard output)")
          ->type_name("FILE");
  auto* coco = verb->add_option("--coco", arguments->coco_file,
                                "Write images, categories and boxes as COCO's tools read them")
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
  verb->callback([arguments, json, coco, out, &chosen] {
    if (json->count() + coco->count() + out->count() == 0)
      throw CLI::RequiredError("--json FILE, --coco FILE or --out DIR");
    chosen = [arguments] { return Detect(*arguments); };
  });
}

}  // namespace plumbline
