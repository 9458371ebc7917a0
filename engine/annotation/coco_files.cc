// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/coco_files.h"

#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/annotation/instance_masks.h"
#include "engine/base/files.h"
#include "engine/vision/category_names.h"

namespace plumbline {
namespace {

/// Numbers of the document's categories: COCO's where it has them.
std::map<std::string, int> NumberCategories(const AnnotationDocument& document) {
  std::map<std::string, int> numbers;
  for (const AnnotatedInstance& instance : document.instances) numbers[instance.category] = 0;
  int next = kFirstNumberBeyondCoco;
  for (auto& [name, number] : numbers) {
    const std::optional<int> coco = CocoNumber(name);
    number = coco ? *coco : next++;
  }
  return numbers;
}

Status WriteInto(const std::filesystem::path& folder, const std::string& name,
                 const cv::Mat& image) {
  if (cv::imwrite((folder / name).string(), image)) return {};
  return Error{ErrorCode::kIo, "cannot write '" + (folder / name).string() + "'"};
}

/// The file as it grows, image by image.
class CocoFile {
 public:
  CocoFile(const AnnotationDocument& document, const ExchangeInputs& inputs,
           std::filesystem::path folder)
      : document_(document),
        inputs_(inputs),
        folder_(std::move(folder)),
        numbers_(NumberCategories(document)) {}

  /// Frames without a pose or a readable image are left out. Errors: kIo, kCorrupt.
  Status Add(int frame) {
    const auto scan_from_cam = ScanFromCam(document_, *inputs_.sequence, frame);
    const Result<Frame> image = inputs_.sequence->ReadFrame(frame);
    if (!scan_from_cam || !image.ok()) return {};
    const Result<cv::Mat> depth = DepthOrNothing(*inputs_.sequence, frame);
    if (!depth) return depth.error();
    const FrameMasks masks = MasksOfFrame(document_, *inputs_.models, inputs_.sequence->camera(),
                                          *scan_from_cam, *depth);
    const std::string name = fmt::format("{:06d}.png", frame);
    images_.push_back({{"id", frame + 1},  // some readers take 0 for none
                       {"file_name", "images/" + name},
                       {"width", image->image.cols},
                       {"height", image->image.rows},
                       {"frame", frame},
                       {"stamp_ns", image->stamp_ns}});
    for (std::size_t i = 0; i < document_.instances.size(); ++i)
      AddInstance(frame, static_cast<int>(i), masks);
    const Status written = WriteInto(folder_ / "images", name, image->image);
    return written.ok() ? WriteInto(folder_ / "masks", name, masks.shown) : written;
  }

  Status Write() const {
    nlohmann::json categories = nlohmann::json::array();
    for (const auto& [name, number] : numbers_)
      categories.push_back({{"id", number}, {"name", name}, {"supercategory", "object"}});
    return WriteJson(folder_ / "instances.json",
                     {{"info", {{"description", "Posed models, written by Plumbline"}}},
                      {"licenses", nlohmann::json::array()},
                      {"images", images_},
                      {"categories", categories},
                      {"annotations", annotations_}});
  }

 private:
  void AddInstance(int frame, int place, const FrameMasks& masks) {
    const cv::Mat shows = masks.shown == place + 1;
    const int area = cv::countNonZero(shows);
    if (area == 0) return;
    const AnnotatedInstance& instance = document_.instances[static_cast<std::size_t>(place)];
    const cv::Rect box = cv::boundingRect(shows);
    const int all = masks.instances[static_cast<std::size_t>(place)].px_all;
    annotations_.push_back(
        {{"id", annotations_.size() + 1},
         {"image_id", frame + 1},
         {"category_id", numbers_.at(instance.category)},
         {"iscrowd", 0},
         {"area", area},
         {"bbox", {box.x, box.y, box.width, box.height}},
         {"segmentation", {{"size", {shows.rows, shows.cols}}, {"counts", ColumnRuns(shows)}}},
         {"instance", instance.id},
         {"instance_number", place + 1},
         {"model", instance.model},
         {"visible_fraction", static_cast<double>(area) / all}});
  }

  const AnnotationDocument& document_;
  const ExchangeInputs& inputs_;
  std::filesystem::path folder_;
  std::map<std::string, int> numbers_;
  nlohmann::json images_ = nlohmann::json::array(), annotations_ = nlohmann::json::array();
};

}  // namespace

std::vector<int> ColumnRuns(const cv::Mat& mask) {
  std::vector<int> runs = {0};
  bool set = false;
  for (int x = 0; x < mask.cols; ++x) {
    for (int y = 0; y < mask.rows; ++y) {
      if ((mask.at<std::uint8_t>(y, x) != 0) != set) {
        set = !set;
        runs.push_back(0);
      }
      ++runs.back();
    }
  }
  return runs;
}

Status WriteCoco(const AnnotationDocument& document, const ExchangeInputs& inputs,
                 const std::filesystem::path& folder, const WorkContext& context) {
  const Result<std::set<int>> used = UsedModels(document, inputs, "a file in COCO's format");
  if (!used) return used.error();
  for (const char* part : {"images", "masks"}) {
    std::error_code error;
    std::filesystem::create_directories(folder / part, error);
    if (error)
      return Error{ErrorCode::kIo, "cannot make '" + folder.string() + "': " + error.message()};
  }
  CocoFile file(document, inputs, folder);
  int done = 0;
  for (const int frame : inputs.frames) {
    context.report({"frames", done++, static_cast<int>(inputs.frames.size())});
    if (context.stop.stop_requested())
      return Error{ErrorCode::kCancelled, "the export was stopped"};
    if (const Status added = file.Add(frame); !added.ok()) return added;
  }
  return file.Write();
}

}  // namespace plumbline
