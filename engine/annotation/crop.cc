// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/crop.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <nlohmann/json.hpp>

#include "engine/dataset/json_fields.h"
#include "engine/sensor/camera.h"

namespace plumbline {
namespace {

nlohmann::json JsonListOf(const Eigen::VectorXd& vector) {
  return std::vector<double>(vector.data(), vector.data() + vector.size());
}

nlohmann::json RegionToJson(const CropBox& box) {
  return {{"center", JsonListOf(box.center_in_scan)},
          {"size", JsonListOf(box.size_m)},
          {"azimuth", box.azimuth_rad}};
}

nlohmann::json RegionToJson(const CropLasso& lasso) {
  nlohmann::json result = {{"scan_from_cam", IsometryToJson(lasso.scan_from_cam)},
                           {"camera", IntrinsicsToJson(lasso.camera)},
                           {"polygon", nlohmann::json::array()},
                           {"near", lasso.near_m}};
  for (const Eigen::Vector2d& corner : lasso.polygon_px)
    result["polygon"].push_back(JsonListOf(corner));
  if (std::isfinite(lasso.far_m)) result["far"] = lasso.far_m;
  if (lasso.azimuth_rad) result["azimuth"] = *lasso.azimuth_rad;
  return result;
}

std::optional<double> NumberFrom(const nlohmann::json& source, const char* key) {
  const auto found = source.find(key);
  if (found == source.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

Result<CropBox> BoxFrom(const nlohmann::json& source) {
  if (!source.is_object()) return InvalidInput("the 'box' of a crop must be a JSON object");
  const auto vector = [&](const char* key) {
    return source.contains(key) ? VectorFromJson(source[key], 3) : std::nullopt;
  };
  const auto center = vector("center"), size = vector("size");
  if (!center || !size) return InvalidInput("the 'box' of a crop needs 'center' and 'size' [m]");
  return CropBox{*center, *size, NumberFrom(source, "azimuth").value_or(0)};
}

/// An image size, which is only for people.
int PixelsFrom(const nlohmann::json& camera, const char* key) {
  return static_cast<int>(std::clamp(NumberFrom(camera, key).value_or(0), 0.0, 32768.0));
}

Result<CropLasso> LassoFrom(const nlohmann::json& source) {
  if (!source.is_object()) return InvalidInput("the 'lasso' of a crop must be a JSON object");
  const auto pose =
      source.contains("scan_from_cam") ? IsometryFromJson(source["scan_from_cam"]) : std::nullopt;
  const nlohmann::json camera = source.value("camera", nlohmann::json::object());
  const auto fx = NumberFrom(camera, "fx"), fy = NumberFrom(camera, "fy"),
             cx = NumberFrom(camera, "cx"), cy = NumberFrom(camera, "cy");
  if (!pose || !fx || !fy || !cx || !cy) {
    return InvalidInput(
        "the 'lasso' of a crop needs 'scan_from_cam', a 4x4 rigid transform, and a "
        "'camera' with fx, fy, cx, cy");
  }
  CropLasso lasso;
  lasso.scan_from_cam = *pose;
  lasso.camera = {PixelsFrom(camera, "width"), PixelsFrom(camera, "height"), *fx, *fy, *cx, *cy};
  for (const nlohmann::json& corner : source.value("polygon", nlohmann::json::array())) {
    const auto pixel = VectorFromJson(corner, 2);
    if (!pixel) return InvalidInput("the 'polygon' of a crop must be a list of [u, v]");
    lasso.polygon_px.emplace_back(*pixel);
  }
  lasso.near_m = NumberFrom(source, "near").value_or(lasso.near_m);
  lasso.far_m = NumberFrom(source, "far").value_or(lasso.far_m);
  lasso.azimuth_rad = NumberFrom(source, "azimuth");
  return lasso;
}

Status CheckRegion(const CropBox& box) {
  if (!box.center_in_scan.allFinite() || !std::isfinite(box.azimuth_rad) ||
      !(box.size_m.minCoeff() > 0) || !box.size_m.allFinite()) {
    return InvalidInput("a crop's box needs a place, an azimuth and a size above zero");
  }
  return {};
}

Status CheckRegion(const CropLasso& lasso) {
  if (lasso.polygon_px.size() < 3)
    return InvalidInput("a crop's lasso needs at least three corners");
  if (!lasso.scan_from_cam.matrix().allFinite() || !(lasso.camera.fx > 0) ||
      !(lasso.camera.fy > 0)) {
    return InvalidInput("a crop's lasso needs the pose and the focal lengths of its view");
  }
  if (!(lasso.near_m >= 0) || !(lasso.far_m > lasso.near_m)) {
    return InvalidInput("the far end of a crop's lasso must lie behind the near end");
  }
  return {};
}

bool IsFragmentName(const std::string& id) {
  const std::size_t at = id.rfind('_');
  return at != std::string::npos && at > 0 && at + 1 < id.size() &&
         std::all_of(id.begin() + static_cast<std::ptrdiff_t>(at) + 1, id.end(),
                     [](unsigned char c) { return std::isdigit(c) != 0; });
}

}  // namespace

Status CheckCrop(const Crop& crop) {
  const bool plain = std::all_of(crop.id.begin(), crop.id.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
  });
  if (crop.id.empty() || crop.id.front() == '.' || !plain) {
    return InvalidInput("a crop needs a name of letters, digits, '-', '_' and '.', not '" +
                        crop.id + "'");
  }
  if (crop.into == Crop::Into::kFragment && !IsFragmentName(crop.id)) {
    return InvalidInput("the fragment '" + crop.id +
                        "' must be called <model>_<number>, as VISMA's are");
  }
  if (crop.up_in_scan && !(std::abs(crop.up_in_scan->norm() - 1) < 1e-6)) {
    return InvalidInput("the 'up' of a crop must be a unit vector");
  }
  if (crop.support_in_scan && !(std::abs(crop.support_in_scan->head<3>().norm() - 1) < 1e-6)) {
    return InvalidInput("the 'support' of a crop needs a normal of length one");
  }
  return std::visit([](const auto& region) { return CheckRegion(region); }, crop.region);
}

nlohmann::json CropToJson(const Crop& crop) {
  nlohmann::json result = {{"id", crop.id},
                           {"into", crop.into == Crop::Into::kModel ? "model" : "fragment"},
                           {"category", crop.category},
                           {"annotator", crop.annotator}};
  const char* kind = std::holds_alternative<CropBox>(crop.region) ? "box" : "lasso";
  result[kind] = std::visit([](const auto& region) { return RegionToJson(region); }, crop.region);
  if (crop.up_in_scan) result["up"] = JsonListOf(*crop.up_in_scan);
  if (!crop.without_support) {
    result["support"] = "keep";
  } else if (crop.support_in_scan) {
    result["support"] = JsonListOf(*crop.support_in_scan);
  } else {
    result["support"] = "auto";
  }
  if (!crop.note.empty()) result["note"] = crop.note;
  return result;
}

Result<Crop> CropFromJson(const nlohmann::json& source) {
  if (!source.is_object()) return InvalidInput("a crop must be a JSON object");
  Crop crop;
  crop.id = TextFromJson(source, "id").value_or("");
  const std::string into = TextFromJson(source, "into").value_or("model");
  if (into != "model" && into != "fragment") {
    return InvalidInput("crop '" + crop.id + "' goes 'into' a model or a fragment, not '" + into +
                        "'");
  }
  crop.into = into == "model" ? Crop::Into::kModel : Crop::Into::kFragment;
  crop.category = TextFromJson(source, "category").value_or("");
  crop.annotator = TextFromJson(source, "annotator").value_or("");
  crop.note = TextFromJson(source, "note").value_or("");
  if (source.contains("box") == source.contains("lasso")) {
    return InvalidInput("crop '" + crop.id + "' needs either a 'box' or a 'lasso'");
  }
  if (source.contains("box")) {
    Result<CropBox> box = BoxFrom(source["box"]);
    if (!box) return box.error();
    crop.region = *box;
  } else {
    Result<CropLasso> lasso = LassoFrom(source["lasso"]);
    if (!lasso) return lasso.error();
    crop.region = std::move(*lasso);
  }
  if (source.contains("up")) {
    const auto up = VectorFromJson(source["up"], 3);
    if (!up) return InvalidInput("the 'up' of crop '" + crop.id + "' must be three numbers");
    crop.up_in_scan = *up;
  }
  const nlohmann::json support = source.value("support", nlohmann::json("auto"));
  crop.without_support = support != "keep";
  if (crop.without_support && support != "auto") {
    const auto plane = VectorFromJson(support, 4);
    if (!plane) {
      return InvalidInput("the 'support' of crop '" + crop.id +
                          "' must be four numbers [a, b, c, d], auto or keep");
    }
    crop.support_in_scan = *plane;
  }
  if (const Status good = CheckCrop(crop); !good.ok()) return good.error();
  return crop;
}

}  // namespace plumbline
