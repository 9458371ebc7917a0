// SPDX-License-Identifier: Apache-2.0
// Scan conversion: every row of a triangle is a span of pixels, along which inverse depth is
// linear. Spans go in steps of kLanes pixels, so that the processor takes several at once.

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/check.h"
#include "engine/base/vectorised.h"
#include "engine/render/renderer.h"
#include "engine/render/visible.h"

namespace plumbline {
namespace {

constexpr int kLanes = 16;

/// A corner in the image: pixels (centres at integers), and inverse depth [1/m].
struct Corner {
  double u = 0, v = 0, inverse_depth = 0;
};

/// The nearest surface of each pixel and the nearest of another id: inverse depth (0 nothing) and
/// id, above which its luminance is kept. Rows are `stride` apart, at least kLanes longer than the
/// image.
struct Layers {
  int width = 0, height = 0, stride = 0;
  std::vector<float> inverse_depth, second_inverse_depth;
  std::vector<int> id, second_id;
};

constexpr int kIdBits = 16;
constexpr int kIdMask = (1 << kIdBits) - 1;
constexpr int kNothing = kUnknownLuminance8 << kIdBits;  ///< Id 0.

/// An edge from its upper end down: where it crosses a row. Two triangles that share it are given
/// the same ends in the same order, so no pixel between them is left out or drawn by both.
struct Edge {
  double v = 0, u = 0, slope = 0;
  Edge(const Corner& upper, const Corner& lower)
      : v(upper.v), u(upper.u), slope((lower.u - upper.u) / (lower.v - upper.v)) {}
  double At(double row) const { return u + (row - v) * slope; }
};

/// ceil(x) as a column or a row, within [0, limit].
inline int FirstCentre(double x, int limit) {
  return static_cast<int>(std::ceil(std::clamp(x, 0.0, static_cast<double>(limit))));
}

/// Inverse depth of a triangle's plane at a pixel: at_origin + across * u + down * v, kept between
/// its corners' (a sliver's plane is steep, and badly known).
struct Plane {
  double at_origin = 0, across = 0, down = 0;
  float least = 0, most = 0;
};

PLUMBLINE_VECTORISED
void DrawSpan(const Plane& plane, double row, int begin, int end, int id, float* __restrict depth,
              float* __restrict second_depth, int* __restrict ids, int* __restrict second_ids) {
  const auto first = static_cast<float>(plane.at_origin + plane.across * begin + plane.down * row);
  const auto across = static_cast<float>(plane.across);
  const float least = plane.least, most = plane.most;
  for (int x = begin; x < end; x += kLanes) {
    const int left = end - x, done = x - begin;
    for (int lane = 0; lane < kLanes; ++lane) {
      const float there = first + across * static_cast<float>(done + lane);
      const float bounded = there < least ? least : (there > most ? most : there);
      const float w = lane < left ? bounded : 0.0f;
      const float w1 = depth[x + lane], w2 = second_depth[x + lane];
      const int id1 = ids[x + lane], id2 = second_ids[x + lane];
      const bool nearer = w > w1, other = ((id1 ^ id) & kIdMask) != 0, between = w > w2;
      const float behind = nearer ? w1 : (between ? w : w2);
      const int id_behind = nearer ? id1 : (between ? id : id2);
      depth[x + lane] = nearer ? w : w1;
      ids[x + lane] = nearer ? id : id1;
      second_depth[x + lane] = other ? behind : w2;
      second_ids[x + lane] = other ? id_behind : id2;
    }
  }
}

void DrawTriangle(const std::array<Corner, 3>& corners, int id, Layers& layers) {
  std::array<Corner, 3> c = corners;
  if (c[1].v < c[0].v) std::swap(c[0], c[1]);
  if (c[2].v < c[1].v) std::swap(c[1], c[2]);
  if (c[1].v < c[0].v) std::swap(c[0], c[1]);
  const int first_row = FirstCentre(c[0].v, layers.height);
  const int end_row = FirstCentre(c[2].v, layers.height);
  const Corner to_1{c[1].u - c[0].u, c[1].v - c[0].v, c[1].inverse_depth - c[0].inverse_depth};
  const Corner to_2{c[2].u - c[0].u, c[2].v - c[0].v, c[2].inverse_depth - c[0].inverse_depth};
  const double area = to_1.u * to_2.v - to_2.u * to_1.v;
  if (first_row >= end_row || area == 0) return;
  Plane plane;
  plane.across = (to_1.inverse_depth * to_2.v - to_2.inverse_depth * to_1.v) / area;
  plane.down = (to_2.inverse_depth * to_1.u - to_1.inverse_depth * to_2.u) / area;
  plane.at_origin = c[0].inverse_depth - plane.across * c[0].u - plane.down * c[0].v;
  const auto [least, most] =
      std::minmax({c[0].inverse_depth, c[1].inverse_depth, c[2].inverse_depth});
  plane.least = static_cast<float>(least);
  plane.most = static_cast<float>(most);
  const Edge whole(c[0], c[2]), upper(c[0], c[1]), lower(c[1], c[2]);
  for (int row = first_row; row < end_row; ++row) {
    const double one = whole.At(row), two = row < c[1].v ? upper.At(row) : lower.At(row);
    const int begin = FirstCentre(std::min(one, two), layers.width);
    const int end = FirstCentre(std::max(one, two), layers.width);
    if (begin >= end) continue;
    const auto start = static_cast<std::ptrdiff_t>(row) * layers.stride;
    DrawSpan(plane, row, begin, end, id, layers.inverse_depth.data() + start,
             layers.second_inverse_depth.data() + start, layers.id.data() + start,
             layers.second_id.data() + start);
  }
}

PLUMBLINE_VECTORISED
void ReadRow(const float* __restrict inverse_depth, const int* __restrict ids, int count,
             float* __restrict depth, std::uint16_t* __restrict read_ids) {
  for (int x = 0; x < count; ++x) {
    const float w = inverse_depth[x];
    depth[x] = w > 0 ? 1.0f / w : 0.0f;
    read_ids[x] = static_cast<std::uint16_t>(ids[x]);
  }
}

PLUMBLINE_VECTORISED
void ReadLuminanceRow(const int* __restrict ids, int count, std::uint8_t* __restrict luminances) {
  for (int x = 0; x < count; ++x) luminances[x] = static_cast<std::uint8_t>(ids[x] >> kIdBits);
}

/// Of each triangle, as of RenderedMaps::luminance.
std::vector<std::uint8_t> LuminancesOf(const TriangleMesh& mesh) {
  std::vector<std::uint8_t> luminances(mesh.triangles.size(), kUnknownLuminance8);
  if (mesh.colors.empty()) return luminances;
  for (std::size_t t = 0; t < luminances.size(); ++t) {
    float sum = 0;
    for (const int corner : mesh.triangles[t])
      sum += Luminance(mesh.colors[static_cast<std::size_t>(corner)]);
    luminances[t] = static_cast<std::uint8_t>(std::lround(254 * sum / 3));
  }
  return luminances;
}

class ProcessorRenderer final : public Renderer {
 public:
  int AddMesh(const TriangleMesh& mesh) override {
    meshes_.push_back({mesh.vertices, mesh.triangles, LuminancesOf(mesh)});
    bounds_of_mesh_.push_back(BoundingBox(mesh));
    return static_cast<int>(meshes_.size()) - 1;
  }

  RenderedMaps Render(const PinholeCamera& camera, std::span<const RenderInstance> instances,
                      const RenderOptions& options) override {
    PLB_CHECK(camera.width > 0 && camera.height > 0) << "the camera has no image size";
    PLB_CHECK(options.near_m > 0) << "near_m must be positive";
    cv::Rect part;
    const std::vector<VisibleInstance> visible =
        FindVisible(camera, instances, bounds_of_mesh_, options.near_m, part);
    Clear(camera);
    for (const VisibleInstance& instance : visible) Draw(camera, instance, options.near_m);
    RenderedMaps maps;
    Read(part, layers_.inverse_depth, layers_.id, maps.depth, maps.id);
    if (options.contour) maps.contour = ContourOf(maps.depth, maps.id, options.contour_step_m);
    if (options.second_layer)
      Read(part, layers_.second_inverse_depth, layers_.second_id, maps.second_depth,
           maps.second_id);
    if (options.luminance) {
      maps.luminance = ReadLuminances(part, layers_.id);
      if (options.second_layer) maps.second_luminance = ReadLuminances(part, layers_.second_id);
    }
    return maps;
  }

 private:
  struct Mesh {
    std::vector<Eigen::Vector3f> vertices;
    std::vector<Eigen::Vector3i> triangles;
    std::vector<std::uint8_t> luminances;
  };

  void Clear(const PinholeCamera& camera) {
    layers_.width = camera.width;
    layers_.height = camera.height;
    layers_.stride = camera.width + kLanes;
    const auto pixels =
        static_cast<std::size_t>(layers_.stride) * static_cast<std::size_t>(layers_.height);
    layers_.inverse_depth.assign(pixels, 0.0f);
    layers_.second_inverse_depth.assign(pixels, 0.0f);
    layers_.id.assign(pixels, kNothing);
    layers_.second_id.assign(pixels, kNothing);
  }

  void Draw(const PinholeCamera& camera, const VisibleInstance& instance, double near_m) {
    const Mesh& mesh = meshes_[instance.mesh];
    const Eigen::Matrix3f rotation = instance.cam_from_mesh.topLeftCorner<3, 3>();
    const Eigen::Vector3f translation = instance.cam_from_mesh.topRightCorner<3, 1>();
    in_cam_.resize(mesh.vertices.size());
    corners_.resize(mesh.vertices.size());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      in_cam_[i] = rotation * mesh.vertices[i] + translation;
      if (in_cam_[i].z() >= near_m) corners_[i] = Project(camera, in_cam_[i].cast<double>());
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Eigen::Vector3i& triangle = mesh.triangles[t];
      const int id = instance.id | (mesh.luminances[t] << kIdBits);
      const auto a = static_cast<std::size_t>(triangle[0]),
                 b = static_cast<std::size_t>(triangle[1]),
                 c = static_cast<std::size_t>(triangle[2]);
      const int in_front = (in_cam_[a].z() >= near_m ? 1 : 0) + (in_cam_[b].z() >= near_m ? 1 : 0) +
                           (in_cam_[c].z() >= near_m ? 1 : 0);
      if (in_front == 3)
        DrawTriangle({corners_[a], corners_[b], corners_[c]}, id, layers_);
      else if (in_front > 0)
        DrawClipped(camera, {in_cam_[a], in_cam_[b], in_cam_[c]}, near_m, id);
    }
  }

  static Corner Project(const PinholeCamera& camera, const Eigen::Vector3d& in_cam) {
    const double inverse_depth = 1 / in_cam.z();
    return {camera.fx * in_cam.x() * inverse_depth + camera.cx,
            camera.fy * in_cam.y() * inverse_depth + camera.cy, inverse_depth};
  }

  /// What lies beyond the near plane of a triangle that crosses it: three or four corners.
  void DrawClipped(const PinholeCamera& camera, const std::array<Eigen::Vector3f, 3>& triangle,
                   double near_m, int id) {
    std::array<Corner, 4> kept;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d from = triangle[i].cast<double>(),
                            to = triangle[(i + 1) % 3].cast<double>();
      if (from.z() >= near_m) kept[count++] = Project(camera, from);
      if ((from.z() >= near_m) == (to.z() >= near_m)) continue;
      const double share = (near_m - from.z()) / (to.z() - from.z());
      kept[count++] = Project(camera, from + share * (to - from));
    }
    for (std::size_t i = 2; i < count; ++i)
      DrawTriangle({kept[0], kept[i - 1], kept[i]}, id, layers_);
  }

  /// `part` of a layer as maps; the rest of them is 0.
  void Read(const cv::Rect& part, const std::vector<float>& inverse_depth,
            const std::vector<int>& ids, cv::Mat& depth, cv::Mat& id) const {
    const cv::Size size(layers_.width, layers_.height);
    depth = cv::Mat(size, CV_32F, cv::Scalar(0));
    id = cv::Mat(size, CV_16U, cv::Scalar(0));
    for (int y = part.y; y < part.y + part.height; ++y) {
      const auto start = static_cast<std::ptrdiff_t>(y) * layers_.stride + part.x;
      ReadRow(inverse_depth.data() + start, ids.data() + start, part.width,
              depth.ptr<float>(y) + part.x, id.ptr<std::uint16_t>(y) + part.x);
    }
  }

  /// Of `part` of a layer.
  cv::Mat ReadLuminances(const cv::Rect& part, const std::vector<int>& ids) const {
    cv::Mat luminance(layers_.height, layers_.width, CV_8U, cv::Scalar(kUnknownLuminance8));
    for (int y = part.y; y < part.y + part.height; ++y) {
      ReadLuminanceRow(ids.data() + static_cast<std::ptrdiff_t>(y) * layers_.stride + part.x,
                       part.width, luminance.ptr<std::uint8_t>(y) + part.x);
    }
    return luminance;
  }

  std::vector<Mesh> meshes_;
  std::vector<Eigen::AlignedBox3f> bounds_of_mesh_;
  Layers layers_;
  std::vector<Eigen::Vector3f> in_cam_;  ///< Of the mesh that is drawn, with `corners_`.
  std::vector<Corner> corners_;
};

}  // namespace

std::unique_ptr<Renderer> Renderer::CreateOnProcessor() {
  return std::make_unique<ProcessorRenderer>();
}

}  // namespace plumbline
