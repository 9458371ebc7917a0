// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/instance_masks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/render/renderer.h"

namespace plumbline {
namespace {

/// BOP's tolerance of what may lie before the surface and still be its own measurement.
constexpr double kDelta_m = 0.015;
constexpr double kMetresPerMillimetre = 0.001;

/// Around the projections of what of the box is before the near plane; empty if nothing is.
cv::Rect SilhouetteBox(const Eigen::AlignedBox3d& bounds, const Eigen::Isometry3d& cam_from_object,
                       const PinholeCamera& camera, double near_m) {
  std::vector<Eigen::Vector3d> corners, before;
  for (int i = 0; i < 8; ++i) {
    const auto corner = static_cast<Eigen::AlignedBox3d::CornerType>(i);
    corners.emplace_back(cam_from_object * bounds.corner(corner));
  }
  for (int i = 0; i < 8; ++i) {
    const auto at = [&](int k) -> const Eigen::Vector3d& {
      return corners[static_cast<std::size_t>(k)];
    };
    if (at(i).z() >= near_m) before.push_back(at(i));
    for (int bit = 1; bit < 8; bit *= 2) {  // the edges to corners of higher number
      if ((i & bit) != 0 || (at(i).z() >= near_m) == (at(i + bit).z() >= near_m)) continue;
      const double share = (near_m - at(i).z()) / (at(i + bit).z() - at(i).z());
      before.push_back(at(i) + share * (at(i + bit) - at(i)));
    }
  }
  if (before.empty()) return {};
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& point : before) {
    box.extend(camera.Project({point.x(), point.y(), std::max(point.z(), near_m)}));
  }
  const cv::Rect canvas(-camera.width, -camera.height, 3 * camera.width, 3 * camera.height);
  const auto pixel = [](double value, int least, int most) {
    return static_cast<int>(std::clamp(value, 1.0 * least, 1.0 * most));
  };
  const int left = pixel(std::floor(box.min().x()), canvas.x, canvas.br().x),
            top = pixel(std::floor(box.min().y()), canvas.y, canvas.br().y),
            right = pixel(std::ceil(box.max().x()) + 1, canvas.x, canvas.br().x),
            bottom = pixel(std::ceil(box.max().y()) + 1, canvas.y, canvas.br().y);
  return {left, top, std::max(right - left, 0), std::max(bottom - top, 0)};
}

/// Depth [m] of one object, alone, in a part of the canvas.
struct Silhouette {
  cv::Rect part;  ///< In pixels of the image.
  cv::Mat depth;  ///< CV_32F, as large as `part`; 0: it is not there.
};

Silhouette Draw(const CadModel& model, double scale, const Eigen::Isometry3d& cam_from_object,
                const PinholeCamera& camera) {
  const RenderOptions options;
  Silhouette drawn{
      SilhouetteBox(Scaled(model.bounds, scale), cam_from_object, camera, options.near_m), {}};
  if (drawn.part.empty()) return drawn;
  PinholeCamera part = camera;
  part.width = drawn.part.width;
  part.height = drawn.part.height;
  part.cx -= drawn.part.x;
  part.cy -= drawn.part.y;
  const TriangleMesh* mesh = &model.mesh;
  const RenderInstance instance{0, cam_from_object, 1, scale};
  drawn.depth = RayCast(part, std::span(&mesh, 1), std::span(&instance, 1), options).depth;
  return drawn;
}

/// What shows at each pixel so far, and how near.
struct Picture {
  const PinholeCamera& camera;
  const cv::Mat& measured;  ///< CV_16U [mm]; empty: nothing was.
  cv::Mat shown;            ///< CV_16U
  cv::Mat nearest;          ///< CV_32F

  Picture(const PinholeCamera& of, const cv::Mat& depth)
      : camera(of),
        measured(depth),
        shown(of.height, of.width, CV_16U, cv::Scalar(0)),
        nearest(of.height, of.width, CV_32F, cv::Scalar(std::numeric_limits<float>::infinity())) {}

  /// Whether a surface at `z` [m] shows at a pixel, by what was measured there.
  bool Shows(int x, int y, float z, int measured_mm) const {
    if (measured_mm == 0) return true;
    const double ray = std::hypot(1.0, camera.Bearing({x, y}).norm());
    return ray * (z - kMetresPerMillimetre * measured_mm) <= kDelta_m;
  }

  void Add(const Silhouette& drawn, int number, InstanceMask& mask) {
    const cv::Rect part = drawn.part & cv::Rect(0, 0, camera.width, camera.height);
    for (int y = part.y; y < part.br().y; ++y) {
      for (int x = part.x; x < part.br().x; ++x) {
        const float z = drawn.depth.at<float>(y - drawn.part.y, x - drawn.part.x);
        if (z == 0) continue;
        mask.mask.at<std::uint8_t>(y, x) = 255;
        const int measured_mm = measured.empty() ? 0 : measured.at<std::uint16_t>(y, x);
        mask.px_valid += measured_mm > 0;
        if (!Shows(x, y, z, measured_mm)) continue;
        mask.visible.at<std::uint8_t>(y, x) = 255;
        if (z >= nearest.at<float>(y, x)) continue;
        nearest.at<float>(y, x) = z;
        shown.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(number);
      }
    }
  }
};

}  // namespace

FrameMasks MasksOfFrame(const AnnotationDocument& document, const ModelDatabase& models,
                        const PinholeCamera& camera, const Eigen::Isometry3d& scan_from_cam,
                        const cv::Mat& depth) {
  FrameMasks masks;
  Picture picture(camera, depth);
  for (const AnnotatedInstance& instance : document.instances) {
    const auto id = models.Find(instance.model);
    PLB_CHECK(id.has_value()) << "no model " << instance.model;
    const Silhouette drawn = Draw(models.model(*id), instance.scale,
                                  scan_from_cam.inverse() * instance.scan_from_object, camera);
    InstanceMask mask;
    mask.mask = cv::Mat(camera.height, camera.width, CV_8U, cv::Scalar(0));
    mask.visible = mask.mask.clone();
    if (!drawn.part.empty()) {
      const cv::Mat silhouette = drawn.depth > 0;
      mask.px_all = cv::countNonZero(silhouette);
      if (mask.px_all > 0) mask.box_all = cv::boundingRect(silhouette) + drawn.part.tl();
      picture.Add(drawn, static_cast<int>(masks.instances.size()) + 1, mask);
    }
    masks.instances.push_back(std::move(mask));
  }
  if (depth.empty()) {  // then what is nearest hides the rest
    for (std::size_t i = 0; i < masks.instances.size(); ++i)
      masks.instances[i].visible = picture.shown == static_cast<int>(i) + 1;
  }
  masks.shown = picture.shown;
  return masks;
}

Result<std::set<int>> UsedModels(const AnnotationDocument& document, const ExchangeInputs& inputs,
                                 const char* format) {
  if (!inputs.sequence || !inputs.models) {
    return Error{ErrorCode::kInvalidInput,
                 std::string(format) +
                     " needs a sequence with camera poses and a model database; name them "
                     "in the project (edit 'inputs')"};
  }
  std::set<int> used;
  for (const AnnotatedInstance& instance : document.instances) {
    const auto id = inputs.models->Find(instance.model);
    if (!id) {
      return Error{ErrorCode::kInvalidInput, "the model '" + instance.model + "' of '" +
                                                 instance.id + "' is not in the database"};
    }
    used.insert(id->value);
  }
  return used;
}

Result<cv::Mat> DepthOrNothing(const Sequence& sequence, int frame) {
  Result<std::optional<cv::Mat>> depth = sequence.ReadDepth(frame);
  if (!depth) return depth.error();
  return depth->value_or(cv::Mat());
}

Result<cv::Mat> VisibleInstances(const AnnotationDocument& document, const ExchangeInputs& inputs,
                                 int frame) {
  const Result<std::set<int>> used = UsedModels(document, inputs, "a frame's masks");
  if (!used) return used.error();
  const auto scan_from_cam = ScanFromCam(document, *inputs.sequence, frame);
  if (!scan_from_cam) {
    return Error{ErrorCode::kNotFound,
                 "frame " + std::to_string(frame) + " of the sequence has no camera pose"};
  }
  const Result<cv::Mat> depth = DepthOrNothing(*inputs.sequence, frame);
  if (!depth) return depth.error();
  return MasksOfFrame(document, *inputs.models, inputs.sequence->camera(), *scan_from_cam, *depth)
      .shown;
}

}  // namespace plumbline
