// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/crop_comparer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/check.h"
#include "engine/geometry/box.h"
#include "engine/vision/model_lines.h"
#include "engine/vision/vision_resources.h"

namespace plumbline {
namespace {

constexpr int kCropSide = 128, kCropMultiple = 16;  ///< Of the longer side [px], of both.
constexpr float kCropMargin = 0.15f;                ///< Around the shapes, of their box.
constexpr int kLeastSide_px = 24;                   ///< Of their box in the image.
constexpr int kLeastShown = 150;                    ///< Pixels of a shape in the crop.
constexpr float kCropNear_m = 0.1f;
/// Of a lamp above and beside the camera (x right, y down, z forward), and of what it leaves dark.
const Eigen::Vector3f kToLamp = Eigen::Vector3f(0.3f, -0.6f, -1.0f).normalized();
constexpr float kCropAmbient = 0.35f;
constexpr float kMostContrast = 30;  ///< Standard deviation of the drawn shading, of 255.
/// The encoder at an eighth of the size, and what it is fed (assets/networks/edge/edge_net.py).
constexpr const char* kCropLayer = "levels.2/Add_1";
const cv::Scalar kCropMean(104, 117, 123);
constexpr double kCropScale = 1.0 / 58;

/// A part of an image, made small.
struct Crop {
  cv::Rect part;
  cv::Mat image;  ///< CV_8UC3

  /// Where the middle of a pixel of `image` is in the whole one.
  float X(int u) const {
    return static_cast<float>(part.x) +
           (static_cast<float>(u) + 0.5f) * static_cast<float>(part.width) /
               static_cast<float>(image.cols) -
           0.5f;
  }
  float Y(int v) const {
    return static_cast<float>(part.y) +
           (static_cast<float>(v) + 0.5f) * static_cast<float>(part.height) /
               static_cast<float>(image.rows) -
           0.5f;
  }
};

std::optional<Box2> BoxOf(const CadModel& model, const PosedShape& shape,
                          const PinholeCamera& camera) {
  Box2 box{1e9f, 1e9f, -1e9f, -1e9f};
  for (int k = 0; k < 8; ++k) {
    const auto corner = static_cast<Eigen::AlignedBox3f::CornerType>(k);
    const Eigen::Vector3d p =
        shape.cam_from_object * (shape.scale * model.bounds.corner(corner).cast<double>());
    if (p.z() < kCropNear_m) return std::nullopt;
    const auto x = static_cast<float>(camera.fx * p.x() / p.z() + camera.cx);
    const auto y = static_cast<float>(camera.fy * p.y() / p.z() + camera.cy);
    box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x), std::max(box.y1, y)};
  }
  return box;
}

std::optional<Crop> CropAround(const cv::Mat& bgr, const Box2& box) {
  const float dx = kCropMargin * (box.x1 - box.x0) + 8, dy = kCropMargin * (box.y1 - box.y0) + 8;
  const cv::Point first(static_cast<int>(std::max(0.0f, box.x0 - dx)),
                        static_cast<int>(std::max(0.0f, box.y0 - dy)));
  const cv::Point last(static_cast<int>(std::min(static_cast<float>(bgr.cols), box.x1 + dx)),
                       static_cast<int>(std::min(static_cast<float>(bgr.rows), box.y1 + dy)));
  if (last.x - first.x < kLeastSide_px || last.y - first.y < kLeastSide_px) return std::nullopt;
  Crop crop{cv::Rect(first, last), {}};
  const double scale = static_cast<double>(kCropSide) / std::max(crop.part.width, crop.part.height);
  const auto side = [&](int length) {
    return std::max(3, static_cast<int>(std::lround(length * scale / kCropMultiple))) *
           kCropMultiple;
  };
  cv::resize(bgr(crop.part), crop.image, {side(crop.part.width), side(crop.part.height)}, 0, 0,
             scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return crop;
}

/// The shape as it shows in the crop: CV_32F, 0 .. 1; 0 where it does not show.
cv::Mat Draw(const RayScene& scene, const PosedShape& shape, const Box2& box,
             const PinholeCamera& camera, const CropComparer::Occluder& occluder,
             const Crop& crop) {
  const Eigen::Isometry3f cam_from_object = shape.cam_from_object.cast<float>();
  const Eigen::Matrix3f object_from_cam = cam_from_object.linear().transpose();
  const float grown = static_cast<float>(1 / shape.scale);
  const Eigen::Vector3f origin = -grown * (object_from_cam * cam_from_object.translation());
  cv::Mat drawn = cv::Mat::zeros(crop.image.size(), CV_32F);
  for (int v = 0; v < drawn.rows; ++v) {
    const float y = crop.Y(v);
    if (y < box.y0 - 1 || y > box.y1 + 1) continue;
    for (int u = 0; u < drawn.cols; ++u) {
      const float x = crop.X(u);
      if (x < box.x0 - 1 || x > box.x1 + 1) continue;
      const Eigen::Vector3f ray(static_cast<float>((x - camera.cx) / camera.fx),
                                static_cast<float>((y - camera.cy) / camera.fy), 1);
      const RayScene::Hit hit = scene.Cast(origin, grown * (object_from_cam * ray));
      if (hit.distance <= kCropNear_m) continue;
      if (!occluder.depth.empty()) {
        const int column =
            std::clamp(static_cast<int>((x + 0.5f) * static_cast<float>(occluder.depth.cols) /
                                        static_cast<float>(camera.width)),
                       0, occluder.depth.cols - 1);
        const int row =
            std::clamp(static_cast<int>((y + 0.5f) * static_cast<float>(occluder.depth.rows) /
                                        static_cast<float>(camera.height)),
                       0, occluder.depth.rows - 1);
        const float before = occluder.depth.at<float>(row, column);
        if (before > 0 && hit.distance > before + static_cast<float>(occluder.margin_m)) continue;
      }
      Eigen::Vector3f normal = cam_from_object.linear() * hit.normal;
      if (normal.dot(ray) > 0) normal = -normal;  // open meshes show their inside
      drawn.at<float>(v, u) =
          kCropAmbient + (1 - kCropAmbient) * std::max(0.0f, normal.normalized().dot(kToLamp));
    }
  }
  return drawn;
}

/// The crop with the shape in it, as bright, as coloured and about as rich in contrast as what it
/// covers.
cv::Mat Paste(const cv::Mat& image, const cv::Mat& drawn, const cv::Mat& shows) {
  const cv::Scalar colour = cv::mean(image, shows);
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::Scalar mean, contrast, shade, shades;
  cv::meanStdDev(grey, mean, contrast, shows);
  cv::meanStdDev(drawn, shade, shades, shows);
  const double gain =
      std::min(contrast[0], static_cast<double>(kMostContrast)) / (shades[0] + 0.02);
  cv::Mat result = image.clone();
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      if (shows.at<std::uint8_t>(v, u) == 0) continue;
      const double lighter = gain * (drawn.at<float>(v, u) - shade[0]);
      for (int c = 0; c < 3; ++c)
        result.at<cv::Vec3b>(v, u)[c] = cv::saturate_cast<std::uint8_t>(colour[c] + lighter);
    }
  }
  return result;
}

/// Mean over the cells of `weights` of the cosine between two of 1 x C x h x w.
double MeanCosine(const cv::Mat& a, const cv::Mat& b, const cv::Mat& weights) {
  const int channels = a.size[1], cells = a.size[2] * a.size[3];
  const auto *pa = a.ptr<float>(), *pb = b.ptr<float>(), *w = weights.ptr<float>();
  double sum = 0, total = 0;
  for (int i = 0; i < cells; ++i) {
    if (w[i] <= 0) continue;
    double ab = 0, aa = 0, bb = 0;
    for (int c = 0; c < channels; ++c) {
      const float x = pa[c * cells + i], y = pb[c * cells + i];
      ab += x * y;
      aa += x * x;
      bb += y * y;
    }
    sum += w[i] * ab / (std::sqrt(aa * bb) + 1e-6);
    total += w[i];
  }
  return total > 0 ? sum / total : 0;
}

}  // namespace

struct CropComparer::Impl {
  std::shared_ptr<const ModelDatabase> database;
  cv::dnn::Net encoder;
  std::string layer;
  std::map<int, RayScene> scenes;  ///< Of the shapes that were asked for.

  /// The network is read when it is first needed: most runs look at no crop.
  void LoadEncoder() {
    const std::string file = VisionResource("assets/networks/edge/edge.onnx");
    encoder = cv::dnn::readNetFromONNX(file.data(), file.size());
    for (const std::string& name : encoder.getLayerNames())
      if (name.ends_with(kCropLayer)) layer = name;
    PLB_CHECK(!layer.empty());
  }

  cv::Mat Features(const cv::Mat& image) {
    if (layer.empty()) LoadEncoder();
    encoder.setInput(cv::dnn::blobFromImage(image, kCropScale, image.size(), kCropMean));
    return encoder.forward(layer).clone();
  }
};

CropComparer::CropComparer(std::shared_ptr<const ModelDatabase> database)
    : impl_(std::make_unique<Impl>()) {
  impl_->database = std::move(database);
}

CropComparer::~CropComparer() = default;

std::vector<std::optional<double>> CropComparer::Compare(const cv::Mat& bgr,
                                                         const PinholeCamera& camera,
                                                         const Occluder& occluder,
                                                         std::span<const PosedShape> shapes) {
  std::vector<std::optional<double>> result(shapes.size());
  std::vector<std::optional<Box2>> boxes;
  std::optional<Box2> around;
  for (const PosedShape& shape : shapes) {
    boxes.push_back(BoxOf(impl_->database->model(shape.label), shape, camera));
    if (boxes.back()) around = around ? Union(*around, *boxes.back()) : *boxes.back();
  }
  if (!around) return result;
  const std::optional<Crop> crop = CropAround(bgr, *around);
  if (!crop) return result;
  const cv::Mat seen = impl_->Features(crop->image);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (!boxes[i]) continue;
    const ModelId label = shapes[i].label;
    const RayScene& scene =
        impl_->scenes.try_emplace(label.value, impl_->database->model(label).mesh).first->second;
    const cv::Mat drawn = Draw(scene, shapes[i], *boxes[i], camera, occluder, *crop);
    const cv::Mat shows = drawn > 0;
    if (cv::countNonZero(shows) < kLeastShown) continue;
    const cv::Mat expected = impl_->Features(Paste(crop->image, drawn, shows));
    cv::Mat weights;
    shows.convertTo(weights, CV_32F, 1.0 / 255);
    cv::resize(weights, weights, {seen.size[3], seen.size[2]}, 0, 0, cv::INTER_AREA);
    result[i] = MeanCosine(seen, expected, weights);
  }
  return result;
}

}  // namespace plumbline
