// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/occlusion.h"

#include <opencv2/imgproc.hpp>

namespace plumbline {
namespace {

constexpr double kSize = 0.5;  ///< Of the camera's image.
/// Around a contour, at half the image's size: an edge that far off still supports it.
constexpr int kBand_px = 2;
constexpr double kInFrontOfAll_m = 1e-3;

}  // namespace

OcclusionRenderer::OcclusionRenderer(const ModelDatabase& database)
    : renderer_(Renderer::CreateOnProcessor()) {
  for (const CadModel& model : database.models()) {
    mesh_of_model_.push_back(renderer_->AddMesh(model.mesh));
    support_of_model_.push_back(model.support);
    bounds_of_model_.push_back(BoundingBox(model.mesh));
  }
}

RenderedMaps OcclusionRenderer::Render(const PinholeCamera& camera,
                                       const Eigen::Isometry3d& cam_from_world,
                                       std::span<const PlacedModel> objects) {
  return Draw(camera, cam_from_world, objects, false);
}

OcclusionMaps OcclusionRenderer::RenderOccluders(const PinholeCamera& camera,
                                                 const Eigen::Isometry3d& cam_from_world,
                                                 std::span<const PlacedModel> objects) {
  std::vector<ObjectId> raised;
  for (const PlacedModel& object : objects) {
    if (support_of_model_[static_cast<std::size_t>(object.label.value)] != Support::kFloor)
      raised.push_back(object.object);
  }
  return OcclusionMaps(Draw(camera, cam_from_world, objects, true), std::move(raised));
}

RenderedMaps OcclusionRenderer::Draw(const PinholeCamera& camera,
                                     const Eigen::Isometry3d& cam_from_world,
                                     std::span<const PlacedModel> objects,
                                     bool contour_and_second_layer) {
  if (objects.empty()) return {};
  std::vector<RenderInstance> instances;
  for (const PlacedModel& object : InView(camera, cam_from_world, objects)) {
    instances.push_back({mesh_of_model_[static_cast<std::size_t>(object.label.value)],
                         cam_from_world * object.world_from_object, object.object.value,
                         object.scale});
  }
  RenderOptions options;
  options.second_layer = contour_and_second_layer && instances.size() > 1;
  options.contour = contour_and_second_layer;
  options.luminance = contour_and_second_layer;
  return renderer_->Render(camera.Scaled(kSize), instances, options);
}

std::vector<PlacedModel> OcclusionRenderer::InView(const PinholeCamera& camera,
                                                   const Eigen::Isometry3d& cam_from_world,
                                                   std::span<const PlacedModel> objects) const {
  const PinholeCamera drawn = camera.Scaled(kSize);
  std::vector<PlacedModel> in_view;
  for (const PlacedModel& object : objects) {
    if (ImagePart(drawn, cam_from_world * object.world_from_object,
                  bounds_of_model_[static_cast<std::size_t>(object.label.value)], object.scale,
                  RenderOptions{}.near_m))
      in_view.push_back(object);
  }
  return in_view;
}

const cv::Mat& OcclusionMaps::DepthBefore(ObjectId object, ObjectId support) const {
  if (maps_.depth.empty()) return maps_.depth;
  const auto [found, is_new] = depth_before_.try_emplace({object, support});
  if (!is_new) return found->second;
  cv::Mat before = maps_.depth.clone();
  for (int y = 0; y < before.rows; ++y) {
    const auto* id = maps_.id.ptr<std::uint16_t>(y);
    const float* second = maps_.second_depth.empty() ? nullptr : maps_.second_depth.ptr<float>(y);
    float* out = before.ptr<float>(y);
    for (int x = 0; x < before.cols; ++x) {
      if (id[x] == object.value || (support != ObjectId{} && id[x] == support.value))
        out[x] = second != nullptr ? second[x] : 0.0f;
    }
  }
  return found->second = before;
}

const cv::Mat& OcclusionMaps::DepthAndContours(ObjectId object, ObjectId support,
                                               ContoursOf others) const {
  if (maps_.depth.empty()) return maps_.depth;
  if (others == ContoursOf::kRaisedThings && raised_.empty()) return DepthBefore(object, support);
  const cv::Mat own = maps_.id == object.value;
  // One for all that are not drawn: there are many.
  if (cv::countNonZero(own) == 0) object = {};
  const auto [found, is_new] = depth_and_contours_.try_emplace({object, support, others});
  if (!is_new) return found->second;
  cv::Mat contours, band;
  if (others == ContoursOf::kAllOthers) {
    contours = maps_.contour.clone();
  } else {
    for (const ObjectId raised : raised_) maps_.contour.copyTo(contours, maps_.id == raised.value);
  }
  contours.setTo(0, own);
  const int width = 2 * kBand_px + 1;
  cv::dilate(contours, band, cv::getStructuringElement(cv::MORPH_ELLIPSE, {width, width}));
  cv::Mat depth = DepthBefore(object, support).clone();
  depth.setTo(kInFrontOfAll_m, band);
  return found->second = depth;
}

const cv::Mat& OcclusionMaps::LuminanceBehind(ObjectId object) const {
  if (maps_.depth.empty()) return maps_.depth;
  const cv::Mat own = maps_.id == object.value;
  if (cv::countNonZero(own) == 0) object = {};
  const auto [found, is_new] = luminance_behind_.try_emplace(object);
  if (!is_new) return found->second;
  cv::Mat behind = maps_.luminance.clone(), luminance;
  if (maps_.second_luminance.empty())
    behind.setTo(kUnknownLuminance8, own);
  else
    maps_.second_luminance.copyTo(behind, own);
  behind.convertTo(luminance, CV_32F, 1.0 / 254);
  luminance.setTo(kNothingBehind, behind == kUnknownLuminance8);
  return found->second = luminance;
}

}  // namespace plumbline
