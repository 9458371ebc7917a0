// SPDX-License-Identifier: Apache-2.0
#include "engine/render/small_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

constexpr double kOpening = 0.6;  ///< Vertical opening [rad].
constexpr int kSamples = 2;       ///< Per pixel and axis.
constexpr float kHiddenBehind_m = 0.03f;
const cv::Vec3b kGround(35, 29, 25), kPaint(224, 168, 82), kPlain(196, 196, 200);

/// Colour and depth of what was drawn so far.
class Canvas {
 public:
  Canvas(int width, int height)
      : color(height, width, CV_8UC3, cv::Scalar(kGround[0], kGround[1], kGround[2])),
        depth(height, width, CV_32F, cv::Scalar(0)) {}

  void Put(int x, int y, float z, const cv::Vec3b& value) {
    if (x < 0 || y < 0 || x >= color.cols || y >= color.rows) return;
    float& nearest = depth.at<float>(y, x);
    if (nearest > 0 && nearest <= z) return;
    nearest = z;
    color.at<cv::Vec3b>(y, x) = value;
  }

  cv::Mat color, depth;
};

/// A camera that looks at a ball.
struct Eye {
  Eigen::Isometry3f eye_from_scan;
  float focal_px, cx, cy;

  Eye(const PictureView& view, int width, int height) {
    const UprightFrame frame(-view.up);
    const Eigen::Matrix3d& upright = frame.upright_rotation();
    const Eigen::Vector3d back =
        upright * Eigen::Vector3d(std::cos(view.elevation_rad) * std::cos(view.azimuth_rad),
                                  std::cos(view.elevation_rad) * std::sin(view.azimuth_rad),
                                  std::sin(view.elevation_rad));
    const Eigen::Vector3d right = upright.col(2).cross(back).normalized();
    Eigen::Matrix3d rotation;
    rotation.row(0) = right;
    rotation.row(1) = -back.cross(right);
    rotation.row(2) = -back;
    const int least = std::min(width, height);
    const double distance = view.radius_m / std::sin(0.5 * kOpening);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = rotation;
    pose.translation() = -rotation * (view.focus + distance * back);
    eye_from_scan = pose.cast<float>();
    focal_px = static_cast<float>(0.5 * least / std::tan(0.5 * kOpening));
    cx = 0.5f * static_cast<float>(width);
    cy = 0.5f * static_cast<float>(height);
  }
  Vector3f Project(const Vector3f& in_eye) const {
    return {cx + focal_px * in_eye.x() / in_eye.z(), cy + focal_px * in_eye.y() / in_eye.z(),
            in_eye.z()};
  }
};

cv::Vec3b Shaded(const cv::Vec3b& color, float light) {
  const auto channel = [&](int c) {
    return static_cast<std::uint8_t>(
        std::clamp(light * static_cast<float>(color[c]), 0.0f, 255.0f));
  };
  return {channel(0), channel(1), channel(2)};
}

cv::Vec3b ColorAt(const TriangleMesh& mesh, int vertex, const cv::Vec3b& otherwise) {
  if (mesh.colors.size() != mesh.vertices.size()) return otherwise;
  const auto& rgb = mesh.colors[static_cast<std::size_t>(vertex)];
  return {rgb[2], rgb[1], rgb[0]};
}

void DrawTriangle(const Vector3f (&p)[3], const cv::Vec3b& color, Canvas& canvas) {
  const float area =
      (p[1].x() - p[0].x()) * (p[2].y() - p[0].y()) - (p[1].y() - p[0].y()) * (p[2].x() - p[0].x());
  if (std::abs(area) < 1e-6f) return;
  const auto low = [](float a, float b, float c) {
    return static_cast<int>(std::floor(std::min({a, b, c})));
  };
  const auto high = [](float a, float b, float c) {
    return static_cast<int>(std::ceil(std::max({a, b, c})));
  };
  const int x0 = std::max(0, low(p[0].x(), p[1].x(), p[2].x()));
  const int x1 = std::min(canvas.color.cols - 1, high(p[0].x(), p[1].x(), p[2].x()));
  const int y0 = std::max(0, low(p[0].y(), p[1].y(), p[2].y()));
  const int y1 = std::min(canvas.color.rows - 1, high(p[0].y(), p[1].y(), p[2].y()));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
      const float w1 =
          ((px - p[0].x()) * (p[2].y() - p[0].y()) - (py - p[0].y()) * (p[2].x() - p[0].x())) /
          area;
      const float w2 =
          ((p[1].x() - p[0].x()) * (py - p[0].y()) - (p[1].y() - p[0].y()) * (px - p[0].x())) /
          area;
      const float w0 = 1 - w1 - w2;
      if (w0 < 0 || w1 < 0 || w2 < 0) continue;
      canvas.Put(x, y, w0 * p[0].z() + w1 * p[1].z() + w2 * p[2].z(), color);
    }
  }
}

/// `paint`: instead of the mesh's own colours.
void DrawMesh(const TriangleMesh& mesh, const Eigen::Isometry3d& scan_from_mesh, const Eye& eye,
              const cv::Vec3b* paint, Canvas& canvas) {
  const Eigen::Isometry3f eye_from_mesh = eye.eye_from_scan * scan_from_mesh.cast<float>();
  const Vector3f light = Vector3f(-0.35f, -0.75f, -0.6f).normalized();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    Vector3f in_eye[3], on_screen[3];
    bool in_front = true;
    for (int i = 0; i < 3; ++i) {
      in_eye[i] = eye_from_mesh * mesh.vertices[static_cast<std::size_t>(t[i])];
      in_front = in_front && in_eye[i].z() > 0.02f;
      on_screen[i] = eye.Project(in_eye[i]);
    }
    if (!in_front) continue;
    Vector3f normal = (in_eye[1] - in_eye[0]).cross(in_eye[2] - in_eye[0]).normalized();
    if (normal.dot(in_eye[0]) > 0) normal = -normal;  // meshes may be open: both sides are drawn
    const float bright = 0.42f + 0.62f * std::max(0.0f, normal.dot(light));
    const cv::Vec3b base = paint != nullptr ? *paint : ColorAt(mesh, t[0], kPlain);
    DrawTriangle(on_screen, Shaded(base, bright), canvas);
  }
}

void DrawPoints(const TriangleMesh& points, const Eye& eye, float size_m, Canvas& canvas) {
  for (std::size_t i = 0; i < points.vertices.size(); ++i) {
    const Vector3f in_eye = eye.eye_from_scan * points.vertices[i];
    if (in_eye.z() < 0.05f) continue;
    const Vector3f p = eye.Project(in_eye);
    const int half =
        std::clamp(static_cast<int>(0.5f * size_m * eye.focal_px / in_eye.z() + 0.5f), 1, 6);
    const cv::Vec3b color =
        Shaded(ColorAt(points, static_cast<int>(i), cv::Vec3b(150, 150, 150)), 0.85f);
    for (int dy = -half; dy <= half; ++dy) {
      for (int dx = -half; dx <= half; ++dx) {
        canvas.Put(static_cast<int>(p.x()) + dx, static_cast<int>(p.y()) + dy, in_eye.z(), color);
      }
    }
  }
}

cv::Mat Shrunk(const cv::Mat& large, int width, int height) {
  cv::Mat picture;
  cv::resize(large, picture, {width, height}, 0, 0, cv::INTER_AREA);
  return picture;
}

}  // namespace

cv::Mat ModelPicture(const TriangleMesh& model, int width, int height) {
  const Eigen::AlignedBox3f box = BoundingBox(model);
  PictureView view;
  view.focus = box.center().cast<double>();
  view.radius_m = std::max(0.02, 0.5 * static_cast<double>(box.diagonal().norm()));
  view.azimuth_rad = 40 * std::numbers::pi / 180;  // fronts are +x
  view.elevation_rad = 0.42;
  Canvas canvas(kSamples * width, kSamples * height);
  DrawMesh(model, Eigen::Isometry3d::Identity(), Eye(view, canvas.color.cols, canvas.color.rows),
           nullptr, canvas);
  return Shrunk(canvas.color, width, height);
}

cv::Mat PlacementPicture(const TriangleMesh& scan_part, const TriangleMesh& model,
                         const Eigen::Isometry3d& scan_from_model, const PictureView& view,
                         int width, int height) {
  Canvas scan(kSamples * width, kSamples * height), posed(kSamples * width, kSamples * height);
  const Eye eye(view, scan.color.cols, scan.color.rows);
  DrawPoints(scan_part, eye, 0.012f, scan);
  DrawMesh(model, scan_from_model, eye, &kPaint, posed);
  for (int y = 0; y < scan.color.rows; ++y) {
    for (int x = 0; x < scan.color.cols; ++x) {
      const float z = posed.depth.at<float>(y, x), before = scan.depth.at<float>(y, x);
      if (z <= 0) continue;
      const bool hidden = before > 0 && before + kHiddenBehind_m < z;
      const float share = hidden ? 0.15f : 0.7f;
      cv::Vec3b& pixel = scan.color.at<cv::Vec3b>(y, x);
      const cv::Vec3b& paint = posed.color.at<cv::Vec3b>(y, x);
      for (int c = 0; c < 3; ++c) {
        pixel[c] = static_cast<std::uint8_t>((1 - share) * static_cast<float>(pixel[c]) +
                                             share * static_cast<float>(paint[c]));
      }
    }
  }
  return Shrunk(scan.color, width, height);
}

}  // namespace plumbline
