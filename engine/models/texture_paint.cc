// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/models/mesh_cleanup.h"
#include "engine/models/textured_mesh.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

constexpr float kSmallestMark = 0.075f;        ///< Half the step of luminance that makes a mark.
constexpr float kSmallestFace_share = 0.006f;  ///< Of the diagonal: a pixel of the views.
constexpr int kMostSamples = 16;               ///< Along an edge.

/// Rec. 601, as a camera's grey; 0 .. 1.
float GreyOf(const Vector3f& rgb) {
  return (0.299f * rgb.x() + 0.587f * rgb.y() + 0.114f * rgb.z()) / 255.0f;
}

Vector3f OwnColor(const TriangleMesh& mesh, int vertex) {
  if (mesh.colors.empty()) return Vector3f::Constant(255);
  const auto& rgb = mesh.colors[static_cast<std::size_t>(vertex)];
  return {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
}

/// What the mesh shows at a point of a face: the texture times the colours.
Vector3f LookAt(const cv::Mat& texture, const TriangleMesh& mesh, const Eigen::Vector3i& t,
                const Vector3f& weights) {
  Eigen::Vector2f uv(0, 0);
  Vector3f own(0, 0, 0);
  for (int c = 0; c < 3; ++c) {
    uv += weights[c] * mesh.texture_coordinates[static_cast<std::size_t>(t[c])];
    own += weights[c] * OwnColor(mesh, t[c]);
  }
  return TexelAt(texture, uv).cwiseProduct(own) / 255.0f;
}

/// Cuts edges, always the longest of a face and of its neighbours across it (Rivara 1984), so that
/// faces keep their shape and no corner lies on another face's edge.
class FaceCutter {
 public:
  FaceCutter(const cv::Mat& texture, TriangleMesh& mesh)
      : texture_(texture),
        mesh_(mesh),
        place_(FirstAtEachPlace(mesh)),
        smallest_(kSmallestFace_share * BoundingBox(mesh).diagonal().norm()) {
    for (int i = 0; i < Count(); ++i) Enter(i);
  }

  void CutTo(int faces) {
    while (Count() < faces && !worst_.empty()) {
      const Ranked next = worst_.top();
      worst_.pop();
      if (next.version != version_[static_cast<std::size_t>(next.face)]) continue;
      const int before = Count();
      while (next.version == version_[static_cast<std::size_t>(next.face)] && Count() < faces)
        CutLongestFrom(next.face);
      if (Count() == before) break;
    }
  }

 private:
  using Edge = std::pair<int, int>;  ///< Two places, the lower one first.
  struct Ranked {
    float badness;
    int face, version;
    bool operator<(const Ranked& other) const {
      return std::tie(badness, other.face) < std::tie(other.badness, face);
    }
  };

  int Count() const { return static_cast<int>(mesh_.triangles.size()); }
  Eigen::Vector3i& Corners(int face) { return mesh_.triangles[static_cast<std::size_t>(face)]; }
  const Vector3f& At(int vertex) const { return mesh_.vertices[static_cast<std::size_t>(vertex)]; }

  Edge EdgeOf(int face, int side) {
    const int a = place_[static_cast<std::size_t>(Corners(face)[side])];
    const int b = place_[static_cast<std::size_t>(Corners(face)[(side + 1) % 3])];
    return std::minmax(a, b);
  }

  /// Of equal edges the one between the first places, so that neighbours agree.
  std::pair<float, Edge> Longest(int face) {
    std::pair<float, Edge> longest{-1, {}};
    for (int side = 0; side < 3; ++side) {
      const Edge edge = EdgeOf(face, side);
      longest = std::max(longest, {(At(edge.first) - At(edge.second)).squaredNorm(), edge});
    }
    return longest;
  }

  /// How much of what the face shows its corners do not; 0: nothing that matters.
  float Badness(int face) {
    const Eigen::Vector3i t = Corners(face);
    const float length = std::sqrt(Longest(face).first);
    if (length < smallest_) return 0;
    float texels = 0;
    for (int side = 0; side < 3; ++side) {
      const Eigen::Vector2f along =
          mesh_.texture_coordinates[static_cast<std::size_t>(t[(side + 1) % 3])] -
          mesh_.texture_coordinates[static_cast<std::size_t>(t[side])];
      texels = std::max({texels, std::abs(along.x()) * static_cast<float>(texture_.cols),
                         std::abs(along.y()) * static_cast<float>(texture_.rows)});
    }
    const int n = std::clamp(static_cast<int>(std::ceil(std::min(texels, 1e4f))), 2, kMostSamples);
    Vector3f corners;
    for (int c = 0; c < 3; ++c) corners[c] = GreyOf(LookAt(texture_, mesh_, t, Vector3f::Unit(c)));
    std::array<std::array<float, kMostSamples + 1>, kMostSamples + 1> off;
    for (int i = 0; i <= n; ++i) {
      for (int k = 0; i + k <= n; ++k) {
        const Vector3f weights = Vector3f(n - i - k, i, k) / static_cast<float>(n);
        off[i][k] = GreyOf(LookAt(texture_, mesh_, t, weights)) - weights.dot(corners);
      }
    }
    // Means of three neighbours: a single texel is noise.
    float most = 0, sum = 0;
    for (int i = 0; i < n; ++i) {
      for (int k = 0; i + k < n; ++k) {
        const float mean = std::abs(off[i][k] + off[i + 1][k] + off[i][k + 1]) / 3;
        most = std::max(most, mean);
        sum += mean * mean;
      }
    }
    if (most < kSmallestMark) return 0;
    const float area = (At(t[1]) - At(t[0])).cross(At(t[2]) - At(t[0])).norm();
    return area * sum / static_cast<float>(n * n);
  }

  void Enter(int face) {
    version_.resize(mesh_.triangles.size(), 0);
    const int version = ++version_[static_cast<std::size_t>(face)];
    for (int side = 0; side < 3; ++side) faces_of_[EdgeOf(face, side)].push_back(face);
    if (const float badness = Badness(face); badness > 0) worst_.push({badness, face, version});
  }

  void Leave(int face) {
    for (int side = 0; side < 3; ++side) std::erase(faces_of_[EdgeOf(face, side)], face);
  }

  /// Cuts the first edge, on the way over ever longer ones, that is the longest of all its faces.
  void CutLongestFrom(int face) {
    std::pair<float, Edge> longest = Longest(face);
    for (bool found = false; !found;) {
      found = true;
      for (const int neighbour : faces_of_[longest.second]) {
        const auto other = Longest(neighbour);
        if (other <= longest) continue;
        longest = other;
        found = false;
        break;
      }
    }
    Cut(longest.second);
  }

  void Cut(const Edge& edge) {
    const std::vector<int> faces = faces_of_[edge];
    int place = -1;  // Of the new corners; texture seams have several vertices at a place.
    std::map<Edge, int> middles;
    for (const int face : faces) {
      int side = 0;
      while (EdgeOf(face, side) != edge) ++side;
      const Eigen::Vector3i t = Corners(face);
      const int a = t[side], b = t[(side + 1) % 3], c = t[(side + 2) % 3];
      const auto [middle, is_new] = middles.try_emplace(std::minmax(a, b), 0);
      if (is_new) middle->second = AddMiddle(a, b, place);
      Leave(face);
      Corners(face) = {a, middle->second, c};
      Enter(face);
      mesh_.triangles.emplace_back(middle->second, b, c);
      Enter(Count() - 1);
    }
    faces_of_.erase(edge);
  }

  int AddMiddle(int a, int b, int& place) {
    const auto i = static_cast<std::size_t>(a), k = static_cast<std::size_t>(b);
    const int middle = static_cast<int>(mesh_.vertices.size());
    if (place < 0) place = middle;
    mesh_.vertices.push_back(place == middle ? Vector3f(0.5f * (At(a) + At(b))) : At(place));
    mesh_.texture_coordinates.push_back(
        0.5f * (mesh_.texture_coordinates[i] + mesh_.texture_coordinates[k]));
    if (!mesh_.colors.empty()) {
      std::array<std::uint8_t, 3> rgb;
      for (std::size_t c = 0; c < 3; ++c)
        rgb[c] = static_cast<std::uint8_t>((mesh_.colors[i][c] + mesh_.colors[k][c] + 1) / 2);
      mesh_.colors.push_back(rgb);
    }
    place_.push_back(place);
    return middle;
  }

  const cv::Mat& texture_;
  TriangleMesh& mesh_;
  std::vector<int> place_;  ///< Of each vertex, the first vertex there.
  float smallest_;
  std::map<Edge, std::vector<int>> faces_of_;
  std::vector<int> version_;
  std::priority_queue<Ranked> worst_;
};

}  // namespace

void PaintVertices(const cv::Mat& texture, TriangleMesh& mesh) {
  // Within the third of a face that is nearest to a corner.
  static const std::array<Vector3f, 6> kNear = {{{0.9f, 0.05f, 0.05f},
                                                 {0.75f, 0.2f, 0.05f},
                                                 {0.75f, 0.05f, 0.2f},
                                                 {0.6f, 0.35f, 0.05f},
                                                 {0.6f, 0.05f, 0.35f},
                                                 {0.5f, 0.25f, 0.25f}}};
  std::vector<Vector3f> sums(mesh.vertices.size(), Vector3f::Zero());
  std::vector<float> weights(mesh.vertices.size(), 0);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto at = [&](int c) { return mesh.vertices[static_cast<std::size_t>(t[c])]; };
    const float area = (at(1) - at(0)).cross(at(2) - at(0)).norm() + 1e-12f;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3i turned(t[c], t[(c + 1) % 3], t[(c + 2) % 3]);
      const auto vertex = static_cast<std::size_t>(t[c]);
      for (const Vector3f& near : kNear) sums[vertex] += area * LookAt(texture, mesh, turned, near);
      weights[vertex] += area * static_cast<float>(kNear.size());
    }
  }
  std::vector<std::array<std::uint8_t, 3>> colors(mesh.vertices.size(), {255, 255, 255});
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const Vector3f color = weights[i] > 0 ? Vector3f(sums[i] / weights[i])
                                          : TexelAt(texture, mesh.texture_coordinates[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      const long level = std::lround(color[static_cast<int>(c)]);
      colors[i][c] = static_cast<std::uint8_t>(std::clamp(level, 0L, 255L));
    }
  }
  mesh.colors = std::move(colors);
}

void PaintByTexture(const cv::Mat& texture, int faces, TriangleMesh& mesh) {
  mesh.normals.clear();
  FaceCutter(texture, mesh).CutTo(faces);
  PaintVertices(texture, mesh);
}

}  // namespace plumbline
