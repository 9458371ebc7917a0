// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/network_guess.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/vision/category_names.h"
#include "engine/vision/distance_heads.h"
#include "engine/vision/exporter_notes.h"
#include "engine/vision/network.h"
#include "engine/vision/onnx_for_opencv.h"
#include "engine/vision/usual_feeding.h"

namespace plumbline {
namespace {

constexpr int kLargestSize = 8192;  // [px] a side, as sidecars may say
constexpr int kUsualSize = 640;     // [px] where a file leaves the size open

/// Cells of grids of these strides.
int CellsOf(const NetworkSidecar& sidecar, const std::vector<int>& strides) {
  int cells = 0;
  for (const int stride : strides)
    cells += ((sidecar.width + stride - 1) / stride) * ((sidecar.height + stride - 1) / stride);
  return cells;
}

std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

/// What is known before the network runs; collects the reasons.
class Guesser {
 public:
  Guesser(const OnnxFile& onnx, const std::vector<std::string>& categories) : onnx_(onnx) {
    for (const std::string& name : categories) names_.push_back(CategoryName(name));
    given_ = !names_.empty();
    if (!given_) names_ = NotedNames(onnx);
    if (!given_ && !names_.empty())
      Say("The file names its " + std::to_string(names_.size()) + " categories.");
  }

  /// Errors: kUnsupported.
  Status TakeInput() {
    if (onnx_.inputs.size() != 1 || onnx_.inputs[0].shape.size() != 4 ||
        onnx_.inputs[0].shape[1] != 3) {
      return Error{ErrorCode::kUnsupported, "does not take one colour image (an input of 1x3xHxW)"};
    }
    const std::vector<int>& shape = onnx_.inputs[0].shape;
    NetworkSidecar& s = guess_.sidecar;
    s.height = shape[2];
    s.width = shape[3];
    if (s.width > kLargestSize || s.height > kLargestSize) {
      return Error{ErrorCode::kUnsupported, "takes images of " + SizeText(s.width, s.height) +
                                                "; this version takes up to " +
                                                std::to_string(kLargestSize) + " pixels a side"};
    }
    if (s.width > 0 && s.height > 0) return {};
    const std::optional<cv::Size> noted = NotedSize(onnx_);
    s.width = noted ? noted->width : kUsualSize;
    s.height = noted ? noted->height : kUsualSize;
    Say("The file leaves the size of its input open; " + SizeText(s.width, s.height) +
        (noted ? " is what its exporter noted." : " is usual."));
    return {};
  }

  /// Errors: kUnsupported, kInvalidInput.
  Status TakeOutputs(const std::vector<cv::Mat>& outputs) {
    std::vector<std::vector<int>> shapes;
    for (const cv::Mat& output : outputs)
      shapes.emplace_back(output.size.p, output.size.p + output.dims);
    const bool known = outputs.size() == 1         ? TakeOne(shapes[0], outputs[0])
                       : AreCellsAndSides(outputs) ? TakeCellsAndSides(shapes)
                                                   : TakeSeveral(shapes) || TakeMasks(shapes);
    if (!known) {
      return Error{ErrorCode::kUnsupported,
                   "gives outputs of " + ShapesText(outputs) +
                       ", which no kind of network that this version knows gives; write its "
                       "sidecar by hand (docs/formats.md) if it is one of them after all"};
    }
    Say("Outputs of " + ShapesText(outputs) + " for an input of " +
        SizeText(guess_.sidecar.width, guess_.sidecar.height) + ": " +
        std::string(NameOf(guess_.sidecar.kind)) + ".");
    Say(FeedAsUsual(guess_.sidecar));
    return guess_.sidecar.kind == NetworkKind::kEdge ? Status() : NameCategories();
  }

  const NetworkSidecar& sidecar() const { return guess_.sidecar; }
  NetworkGuess Take() { return std::move(guess_); }

 private:
  void Say(std::string reason) { guess_.reasons.push_back(std::move(reason)); }

  bool Is(NetworkKind kind, int categories, std::vector<int> strides = {}) {
    if (kind != NetworkKind::kEdge && categories < 1) return false;
    guess_.sidecar.kind = kind;
    guess_.sidecar.strides = std::move(strides);
    categories_ = categories;
    return true;
  }

  /// Boxes that the network has chosen do not tell how many categories there are.
  bool IsChosen(NetworkKind kind) {
    Is(kind, 1, kind == NetworkKind::kYolov10 ? std::vector{8, 16, 32} : std::vector<int>());
    categories_ = static_cast<int>(names_.size());
    return true;
  }

  /// As LeaveOutBoxDecoding leaves YOLOv8 and its followers.
  bool TakeCellsAndSides(const std::vector<std::vector<int>>& shapes) {
    const std::vector<int>& scores = shapes[shapes[0].size() == 3 ? 0 : 1];
    for (const std::vector<int>& strides :
         {std::vector{8, 16, 32}, {8, 16, 32, 64}, {4, 8, 16, 32}}) {
      if (scores[1] != CellsOf(guess_.sidecar, strides)) continue;
      Say("It ends as YOLOv8 does; its boxes are decoded here, and every cell of it scores.");
      return Is(NetworkKind::kYolov8, scores[2], strides);
    }
    return false;
  }

  /// Boxes with coefficients of masks, and the masks [1, coefficients, rows, columns].
  bool TakeMasks(const std::vector<std::vector<int>>& shapes) {
    if (shapes.size() != 2 || shapes[0].size() + shapes[1].size() != 3 + 4) return false;
    const std::vector<int>& boxes = shapes[shapes[0].size() == 3 ? 0 : 1];
    const int masks = shapes[shapes[0].size() == 3 ? 1 : 0][1];
    const std::vector<int> three = {8, 16, 32};
    const int cells = CellsOf(guess_.sidecar, three);
    Say("It also gives masks, " + std::to_string(masks) + " numbers a box: they are not used.");
    if (boxes[1] == 3 * cells) return Is(NetworkKind::kYolov5, boxes[2] - 5 - masks);
    if (boxes[2] == cells) return Is(NetworkKind::kYolov8, boxes[1] - 4 - masks, three);
    if (boxes[2] == 6 + masks) return IsChosen(NetworkKind::kYolov10);
    return false;
  }

  bool TakeOne(const std::vector<int>& shape, const cv::Mat& output) {
    const NetworkSidecar& s = guess_.sidecar;
    if (shape.size() == 4 && shape[1] == 1 && shape[2] == s.height && shape[3] == s.width)
      return Is(NetworkKind::kEdge, 0);
    if (shape.size() == 4 && shape[1] > 5 && shape[2] == s.height / 16 && shape[3] == s.width / 16)
      return Is(NetworkKind::kFastestDet, shape[1] - 5, {16});
    if (shape.size() == 4 && shape[0] == 1 && shape[1] == 1 && shape[3] == 7)
      return IsChosen(NetworkKind::kSsd);
    if (shape.size() != 3 || shape[0] != 1) return false;
    const std::vector<int> three = {8, 16, 32}, four = {8, 16, 32, 64};
    const int cells = CellsOf(s, three), rows = shape[1], columns = shape[2];
    if (rows == cells) {
      // Decoded boxes are in pixels; raw ones lie within a few cells.
      double largest = 0;
      for (int row = 0; row < rows; ++row)
        largest = std::max<double>(largest, output.ptr<float>(0, row)[0]);
      if (largest > 0.5 * s.width) {
        Say("Its boxes come decoded, in pixels.");
        return Is(NetworkKind::kYolov5, columns - 5);
      }
      return Is(NetworkKind::kYolox, columns - 5, three);
    }
    if (rows == 3 * cells) return Is(NetworkKind::kYolov5, NamesOr(columns - 5));
    if (columns == cells) return Is(NetworkKind::kYolov8, NamesOr(rows - 4), three);
    if (columns == 6) return IsChosen(NetworkKind::kYolov10);
    if (rows == CellsOf(s, four) && columns > 32)
      return Is(NetworkKind::kNanodet, columns - 32, four);
    return false;
  }

  /// Networks that also give masks have more rows than categories; the names tell.
  int NamesOr(int categories) const {
    const int names = static_cast<int>(names_.size());
    return names > 0 && names < categories ? names : categories;
  }

  bool TakeSeveral(const std::vector<std::vector<int>>& shapes) {
    const auto of_three = [](const std::vector<int>& shape) {
      return shape.size() == 3 ? shape : std::vector<int>();
    };
    if (shapes.size() == 2 && of_three(shapes[0]).size() == 3 && of_three(shapes[1]).size() == 3 &&
        shapes[0][1] == shapes[1][1]) {
      for (const int corners : {0, 1})
        if (shapes[corners][2] == 4 && shapes[1 - corners][2] > 1)
          return Is(NetworkKind::kSsd, shapes[1 - corners][2] - 1);
    }
    // A level each: scores of all categories, and distances in 8 bins a side.
    const std::vector<int> four = {8, 16, 32, 64};
    if (shapes.size() == 8) {
      int categories = 0;
      std::size_t distances = 0;
      for (const std::vector<int>& shape : shapes) {
        if (shape.size() < 2) return false;
        const int columns = shape.back();
        if (columns == 32) {
          ++distances;
        } else if (categories == 0 || categories == columns) {
          categories = columns;
        } else {
          return false;
        }
      }
      if (distances == 4) return Is(NetworkKind::kPicodet, categories, four);
      return false;
    }
    return false;
  }

  Status NameCategories() {
    std::vector<std::string>& names = guess_.sidecar.categories;
    if (!names_.empty()) {
      if (static_cast<int>(names_.size()) != categories_) {
        return Error{ErrorCode::kInvalidInput, "has " + std::to_string(categories_) +
                                                   " categories, but " +
                                                   std::to_string(names_.size()) + " names are " +
                                                   (given_ ? "given" : "in the file")};
      }
      names = names_;
      return {};
    }
    const auto coco = CocoCategories(), voc = VocCategories();
    if (categories_ == static_cast<int>(coco.size())) {
      names.assign(coco.begin(), coco.end());
      Say("80 categories: those of COCO.");
    } else if (categories_ == static_cast<int>(voc.size())) {
      names.assign(voc.begin(), voc.end());
      Say("20 categories: those of PASCAL VOC.");
    } else {
      return Error{ErrorCode::kInvalidInput,
                   (categories_ > 0 ? "has " + std::to_string(categories_) +
                                          " categories and no names for them; name them"
                                    : "does not say which categories it has; name them") +
                       ", in its order, with --categories FILE (one name a line)"};
    }
    return {};
  }

  const OnnxFile& onnx_;
  std::vector<std::string> names_;
  bool given_ = false;
  int categories_ = 0;
  NetworkGuess guess_;
};

}  // namespace

Result<NetworkGuess> GuessSidecar(const std::filesystem::path& onnx_file,
                                  const std::vector<std::string>& categories) {
  const Result<OnnxFile> onnx = ReadOnnxFile(onnx_file);
  if (!onnx.ok()) return onnx.error();
  const auto told = [&](const Error& error) {
    return Error{error.code, "the network '" + onnx_file.string() + "' " + error.message};
  };
  Guesser guesser(*onnx, categories);
  if (Status status = guesser.TakeInput(); !status.ok()) return told(status.error());
  NetworkSidecar any = guesser.sidecar();
  any.scale = 1 / 255.0;
  Result<Network> network = MakeNetwork(OnnxForOpenCv(onnx->bytes, cv::Size(any.width, any.height)),
                                        any, onnx_file.string(), onnx->content_hash);
  if (!network.ok()) return network.error();
  const cv::Mat gray(any.height, any.width, CV_8UC3, cv::Scalar::all(128));
  const Result<std::vector<cv::Mat>> outputs = RunNetwork(*network, gray);
  if (!outputs.ok()) return outputs.error();
  if (Status status = guesser.TakeOutputs(*outputs); !status.ok()) return told(status.error());
  return guesser.Take();
}

}  // namespace plumbline
