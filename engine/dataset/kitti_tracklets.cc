// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/kitti_tracklets.h"

#include <cmath>
#include <optional>

#include <tinyxml2.h>

#include "engine/base/files.h"
#include "engine/dataset/text_table.h"

namespace plumbline {
namespace {

std::optional<double> NumberIn(const tinyxml2::XMLElement& element, const char* name) {
  const tinyxml2::XMLElement* child = element.FirstChildElement(name);
  if (child == nullptr || child->GetText() == nullptr) return std::nullopt;
  const std::vector<std::string_view> fields = SplitFields(child->GetText());
  const std::optional<double> number = fields.size() == 1 ? ParseNumber(fields[0]) : std::nullopt;
  return number && std::abs(*number) < 1e6 ? number : std::nullopt;
}

std::optional<KittiTracklet> TrackletFrom(const tinyxml2::XMLElement& item) {
  KittiTracklet tracklet;
  const tinyxml2::XMLElement* type = item.FirstChildElement("objectType");
  const tinyxml2::XMLElement* poses = item.FirstChildElement("poses");
  const auto height = NumberIn(item, "h"), width = NumberIn(item, "w"),
             length = NumberIn(item, "l"), first = NumberIn(item, "first_frame");
  if (type == nullptr || type->GetText() == nullptr || poses == nullptr || !height || !width ||
      !length || !first || *first < 0)
    return std::nullopt;
  tracklet.type = type->GetText();
  tracklet.size_m << *length, *width, *height;
  if (!(tracklet.size_m.minCoeff() > 0 && tracklet.size_m.maxCoeff() < 100)) return std::nullopt;
  tracklet.first_frame = static_cast<int>(*first);
  for (const tinyxml2::XMLElement* pose = poses->FirstChildElement("item"); pose != nullptr;
       pose = pose->NextSiblingElement("item")) {
    const auto x = NumberIn(*pose, "tx"), y = NumberIn(*pose, "ty"), z = NumberIn(*pose, "tz"),
               yaw = NumberIn(*pose, "rz");
    if (!x || !y || !z || !yaw) return std::nullopt;
    tracklet.places.push_back({{*x, *y, *z}, *yaw});
  }
  return tracklet;
}

}  // namespace

Result<std::vector<KittiTracklet>> ReadKittiTracklets(const std::filesystem::path& file) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' " + what};
  };
  tinyxml2::XMLDocument document;
  if (document.Parse(text->data(), text->size()) != tinyxml2::XML_SUCCESS)
    return bad("is not XML (line " + std::to_string(document.ErrorLineNum()) + ")");
  const tinyxml2::XMLElement* root = document.RootElement();
  const tinyxml2::XMLElement* list =
      root == nullptr ? nullptr : root->FirstChildElement("tracklets");
  if (list == nullptr) return bad("holds no tracklets");
  std::vector<KittiTracklet> tracklets;
  for (const tinyxml2::XMLElement* item = list->FirstChildElement("item"); item != nullptr;
       item = item->NextSiblingElement("item")) {
    std::optional<KittiTracklet> tracklet = TrackletFrom(*item);
    if (!tracklet)
      return bad("has a tracklet that is none (line " + std::to_string(item->GetLineNum()) + ")");
    tracklets.push_back(std::move(*tracklet));
  }
  return tracklets;
}

}  // namespace plumbline
