// SPDX-License-Identifier: Apache-2.0
#include "engine/models/thing_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>
#include <vector>

namespace plumbline {
namespace {

using enum FrontHabit;

/// Sizes as in shops: of the usual one, not of all.
constexpr std::array kThings = {
    Thing{"backpack", true, 0.5, 0.32, 0.2, 0.35, false, kNone},
    Thing{"bed", true, 0.9, 1.5, 2.05, 0.35, true, kSeat},
    Thing{"bench", true, 0.6, 1.4, 0.45, 0.4, true, kSeat},
    Thing{"bicycle", true, 1.05, 0.6, 1.7, 0.35, true, kNone},
    Thing{"book", true, 0.03, 0.16, 0.23, 0.6, false, kNone},
    Thing{"bottle", true, 0.26, 0.08, 0.08, 0.35, false, kNone},
    Thing{"bowl", true, 0.08, 0.16, 0.16, 0.4, false, kNone},
    Thing{"cell phone", true, 0.01, 0.07, 0.15, 0.35, false, kNone},
    Thing{"chair", true, 0.88, 0.55, 0.55, 0.3, true, kSeat},
    Thing{"clock", true, 0.3, 0.28, 0.06, 0.6, false, kScreen},
    Thing{"couch", true, 0.85, 1.9, 0.95, 0.35, true, kSeat},
    Thing{"cup", true, 0.1, 0.11, 0.085, 0.3, false, kNone},
    Thing{"dining table", true, 0.74, 1.4, 0.85, 0.4, true, kNone},
    Thing{"handbag", true, 0.28, 0.34, 0.14, 0.4, false, kNone},
    Thing{"keyboard", true, 0.03, 0.44, 0.15, 0.4, false, kNone},
    Thing{"laptop", true, 0.2, 0.34, 0.25, 0.5, false, kSeat},
    Thing{"microwave", true, 0.28, 0.48, 0.38, 0.3, false, kDoors},
    Thing{"mouse", true, 0.04, 0.065, 0.11, 0.35, false, kNone},
    Thing{"oven", true, 0.8, 0.6, 0.6, 0.35, true, kDoors},
    Thing{"potted plant", true, 0.6, 0.35, 0.35, 0.6, false, kNone},
    Thing{"refrigerator", true, 1.7, 0.7, 0.68, 0.35, true, kDoors},
    Thing{"remote", true, 0.025, 0.05, 0.18, 0.35, false, kNone},
    Thing{"sink", true, 0.3, 0.6, 0.48, 0.5, false, kNone},
    Thing{"suitcase", true, 0.65, 0.43, 0.26, 0.35, true, kNone},
    Thing{"teddy bear", true, 0.35, 0.28, 0.24, 0.5, false, kNone},
    Thing{"toaster", true, 0.2, 0.3, 0.18, 0.3, false, kNone},
    Thing{"toilet", true, 0.76, 0.38, 0.68, 0.25, true, kSeat},
    Thing{"tv", true, 0.62, 1.0, 0.1, 0.45, false, kScreen},
    Thing{"umbrella", true, 0.85, 0.12, 0.12, 0.5, false, kNone},
    Thing{"vase", true, 0.3, 0.14, 0.14, 0.45, false, kNone},
    Thing{"wine glass", true, 0.21, 0.08, 0.08, 0.25, false, kNone},
    // What COCO has no word for: these keep others from being taken for what they are not.
    Thing{"basket", false, 0.3, 0.4, 0.3, 0.5, false, kNone},
    Thing{"bathtub", false, 0.58, 1.65, 0.75, 0.25, true, kNone},
    Thing{"bin", false, 0.45, 0.3, 0.3, 0.5, true, kNone},
    Thing{"box", false, 0.25, 0.4, 0.3, 0.7, false, kNone},
    Thing{"cabinet", false, 0.9, 1.2, 0.48, 0.55, true, kDoors},
    Thing{"coffee table", false, 0.42, 1.1, 0.6, 0.35, true, kNone},
    Thing{"computer", false, 0.45, 0.45, 0.3, 0.5, false, kSeat},
    Thing{"cooktop", false, 0.1, 0.7, 0.52, 0.5, false, kNone},
    Thing{"counter", false, 0.95, 2.4, 0.65, 0.45, true, kNone},
    Thing{"curtain", false, 2.3, 1.4, 0.1, 0.5, false, kNone},
    Thing{"desk", false, 0.75, 1.4, 0.7, 0.3, true, kDoors},
    Thing{"door", false, 2.0, 0.85, 0.08, 0.3, true, kNone},
    Thing{"dresser", false, 0.85, 1.2, 0.5, 0.35, true, kDoors},
    Thing{"game controller", false, 0.055, 0.155, 0.105, 0.25, false, kNone},
    Thing{"lamp", false, 0.9, 0.35, 0.35, 0.7, false, kNone},
    Thing{"nightstand", false, 0.57, 0.5, 0.42, 0.3, true, kDoors},
    Thing{"ottoman", false, 0.43, 0.65, 0.55, 0.35, true, kNone},
    Thing{"piano", false, 1.15, 1.5, 0.65, 0.35, true, kDoors},
    Thing{"picture", false, 0.6, 0.7, 0.03, 0.7, false, kNone},
    Thing{"printer", false, 0.3, 0.45, 0.4, 0.45, false, kNone},
    Thing{"rack", false, 1.1, 0.85, 0.33, 0.5, true, kNone},
    Thing{"rug", false, 0.015, 1.5, 2.2, 0.5, true, kNone},
    Thing{"shelf", false, 1.5, 0.9, 0.33, 0.6, true, kDoors},
    Thing{"sideboard", false, 0.7, 1.6, 0.45, 0.4, true, kDoors},
    Thing{"speaker", false, 0.5, 0.25, 0.28, 0.6, false, kNone},
    Thing{"stool", false, 0.58, 0.38, 0.38, 0.3, true, kNone},
    Thing{"wardrobe", false, 2.0, 1.3, 0.6, 0.35, true, kDoors},
    Thing{"washing machine", false, 0.85, 0.6, 0.58, 0.15, true, kDoors},
    Thing{"window", false, 1.3, 1.1, 0.1, 0.5, false, kNone},
};

/// Words without spaces and what they stand for; "" for those that make another thing of the word
/// before them ("chair cushion").
constexpr std::array<std::pair<std::string_view, std::string_view>, 86> kWords = {{
    {"sofa", "couch"},
    {"settee", "couch"},
    {"loveseat", "couch"},
    {"futon", "couch"},
    {"table", "dining table"},
    {"diningtable", "dining table"},
    {"mug", "cup"},
    {"teacup", "cup"},
    {"coffeecup", "cup"},
    {"plant", "potted plant"},
    {"houseplant", "potted plant"},
    {"flowerpot", "potted plant"},
    {"pottedplant", "potted plant"},
    {"television", "tv"},
    {"tvmonitor", "tv"},
    {"monitor", "tv"},
    {"screen", "tv"},
    {"fridge", "refrigerator"},
    {"freezer", "refrigerator"},
    {"armchair", "chair"},
    {"recliner", "chair"},
    {"barstool", "stool"},
    {"bike", "bicycle"},
    {"rucksack", "backpack"},
    {"purse", "handbag"},
    {"wineglass", "wine glass"},
    {"goblet", "wine glass"},
    {"cellphone", "cell phone"},
    {"mobilephone", "cell phone"},
    {"smartphone", "cell phone"},
    {"phone", "cell phone"},
    {"notebook", "laptop"},
    {"teddy", "teddy bear"},
    {"teddybear", "teddy bear"},
    {"remotecontrol", "remote"},
    {"microwaveoven", "microwave"},
    {"washbasin", "sink"},
    {"bookshelf", "shelf"},
    {"bookcase", "shelf"},
    {"shelves", "shelf"},
    {"shelving", "shelf"},
    {"cupboard", "cabinet"},
    {"locker", "cabinet"},
    {"closet", "wardrobe"},
    {"armoire", "wardrobe"},
    {"drawers", "dresser"},
    {"commode", "dresser"},
    {"bedside", "nightstand"},
    {"bedsidetable", "nightstand"},
    {"nighttable", "nightstand"},
    {"coffeetable", "coffee table"},
    {"sidetable", "coffee table"},
    {"endtable", "coffee table"},
    {"tvstand", "sideboard"},
    {"tvbench", "sideboard"},
    {"credenza", "sideboard"},
    {"workbench", "desk"},
    {"worktop", "counter"},
    {"countertop", "counter"},
    {"hob", "cooktop"},
    {"stove", "oven"},
    {"cooker", "oven"},
    {"washer", "washing machine"},
    {"dryer", "washing machine"},
    {"dishwasher", "washing machine"},
    {"pc", "computer"},
    {"imac", "computer"},
    {"gamepad", "game controller"},
    {"controller", "game controller"},
    {"container", "box"},
    {"crate", "box"},
    {"trashcan", "bin"},
    {"carpet", "rug"},
    {"painting", "picture"},
    {"mirror", "picture"},
    {"poster", "picture"},
    {"pouf", "ottoman"},
    {"cushion", ""},
    {"pillow", ""},
    {"leg", ""},
    {"stand", ""},
    {"holder", ""},
    {"case", ""},
    {"cover", ""},
    {"bag", ""},
    {"cloth", ""},
}};

std::string Squeezed(std::string_view name) {
  std::string squeezed;
  for (const char c : name) {
    if (c != ' ') squeezed += c;
  }
  return squeezed;
}

/// "TVCabinet_01" is tv, cabinet; "my-red chair2" is my, red, chair.
std::vector<std::string> WordsOf(std::string_view name) {
  std::vector<std::string> words(1);
  const auto is = [&](std::size_t i, int (*kind)(int)) {
    return i < name.size() && kind(static_cast<unsigned char>(name[i])) != 0;
  };
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (!is(i, std::isalpha)) {
      words.emplace_back();
      continue;
    }
    const bool begins =
        is(i, std::isupper) && i > 0 &&
        (is(i - 1, std::islower) || (is(i - 1, std::isupper) && is(i + 1, std::islower)));
    if (begins) words.emplace_back();
    words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
  }
  std::erase(words, "");
  return words;
}

/// The word that stands for a thing, or nothing; a plural as its singular.
std::pair<bool, const Thing*> Known(const std::string& word) {
  for (const std::string& form :
       {word, word.size() > 3 && word.back() == 's' ? word.substr(0, word.size() - 1) : word}) {
    for (const Thing& thing : kThings) {
      if (Squeezed(thing.name) == form) return {true, &thing};
    }
    for (const auto& [other, name] : kWords) {
      if (other == form) return {true, FindThing(name)};
    }
  }
  return {false, nullptr};
}

}  // namespace

const Thing* FindThing(std::string_view name) {
  const auto found = std::find_if(kThings.begin(), kThings.end(),
                                  [&](const Thing& thing) { return thing.name == name; });
  return found == kThings.end() ? nullptr : &*found;
}

const Thing* ThingInName(std::string_view name) {
  const std::vector<std::string> words = WordsOf(name);
  for (std::size_t last = words.size(); last-- > 0;) {
    // "night stand" before "stand".
    if (last > 0) {
      if (const auto [known, thing] = Known(words[last - 1] + words[last]); known) return thing;
    }
    if (const auto [known, thing] = Known(words[last]); known) return thing;
  }
  return nullptr;
}

}  // namespace plumbline
