// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/category_names.h"

#include <algorithm>
#include <cctype>
#include <utility>

namespace plumbline {
namespace {

constexpr std::string_view kCoco[] = {"person",        "bicycle",      "car",
                                      "motorcycle",    "airplane",     "bus",
                                      "train",         "truck",        "boat",
                                      "traffic light", "fire hydrant", "stop sign",
                                      "parking meter", "bench",        "bird",
                                      "cat",           "dog",          "horse",
                                      "sheep",         "cow",          "elephant",
                                      "bear",          "zebra",        "giraffe",
                                      "backpack",      "umbrella",     "handbag",
                                      "tie",           "suitcase",     "frisbee",
                                      "skis",          "snowboard",    "sports ball",
                                      "kite",          "baseball bat", "baseball glove",
                                      "skateboard",    "surfboard",    "tennis racket",
                                      "bottle",        "wine glass",   "cup",
                                      "fork",          "knife",        "spoon",
                                      "bowl",          "banana",       "apple",
                                      "sandwich",      "orange",       "broccoli",
                                      "carrot",        "hot dog",      "pizza",
                                      "donut",         "cake",         "chair",
                                      "couch",         "potted plant", "bed",
                                      "dining table",  "toilet",       "tv",
                                      "laptop",        "mouse",        "remote",
                                      "keyboard",      "cell phone",   "microwave",
                                      "oven",          "toaster",      "sink",
                                      "refrigerator",  "book",         "clock",
                                      "vase",          "scissors",     "teddy bear",
                                      "hair drier",    "toothbrush"};

constexpr std::string_view kVoc[] = {"airplane",     "bicycle", "bird",  "boat",       "bottle",
                                     "bus",          "car",     "cat",   "chair",      "cow",
                                     "dining table", "dog",     "horse", "motorcycle", "person",
                                     "potted plant", "sheep",   "couch", "train",      "tv"};

/// Other words, written without spaces.
constexpr std::pair<std::string_view, std::string_view> kSynonyms[] = {
    {"aeroplane", "airplane"},
    {"bike", "bicycle"},
    {"sofa", "couch"},
    {"settee", "couch"},
    {"table", "dining table"},
    {"houseplant", "potted plant"},
    {"tvmonitor", "tv"},
    {"television", "tv"},
    {"monitor", "tv"},
    {"computermonitor", "tv"},
    {"fridge", "refrigerator"},
    {"motorbike", "motorcycle"},
    {"mobilephone", "cell phone"},
    {"cellphone", "cell phone"},
    {"phone", "cell phone"},
    {"mug", "cup"},
    {"coffeecup", "cup"},
    {"remotecontrol", "remote"},
    {"microwaveoven", "microwave"},
    {"hairdryer", "hair drier"},
    {"hairdrier", "hair drier"},
    {"doughnut", "donut"},
    {"pedestrian", "person"}};

std::string Squeezed(std::string_view name) {
  std::string result;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      result.push_back(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
  return result;
}

}  // namespace

std::optional<int> CocoNumber(std::string_view category) {
  // Of the numbers 1 to 90, these were never used.
  constexpr int kUnused[] = {12, 26, 29, 30, 45, 66, 68, 69, 71, 83};
  int number = 0;
  for (const std::string_view name : kCoco) {
    do {
      ++number;
    } while (std::find(std::begin(kUnused), std::end(kUnused), number) != std::end(kUnused));
    if (name == category) return number;
  }
  return std::nullopt;
}

std::span<const std::string_view> CocoCategories() { return kCoco; }
std::span<const std::string_view> VocCategories() { return kVoc; }

bool MovesByItself(std::string_view category) {
  // In COCO's order from "person" to "boat" and from "bird" to "giraffe".
  static constexpr std::string_view kMovers[] = {
      "person", "bicycle",  "car",  "motorcycle", "airplane", "bus",   "train",
      "truck",  "boat",     "bird", "cat",        "dog",      "horse", "sheep",
      "cow",    "elephant", "bear", "zebra",      "giraffe"};
  return std::find(std::begin(kMovers), std::end(kMovers), category) != std::end(kMovers);
}

std::string CategoryName(std::string_view name) {
  const std::string squeezed = Squeezed(name);
  for (const std::string_view coco : kCoco)
    if (Squeezed(coco) == squeezed) return std::string(coco);
  for (const auto& [word, coco] : kSynonyms)
    if (word == squeezed) return std::string(coco);
  std::string result;
  for (const char c : name)
    result.push_back(c == '_' ? ' '
                              : static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
  return result;
}

}  // namespace plumbline
