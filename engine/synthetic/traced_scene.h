// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "engine/synthetic/room.h"

namespace plumbline {

/// All triangles of a room in one list, ready for ray casting (Embree). Immutable; safe to use from
/// several threads.
class TracedScene {
 public:
  struct Triangle {
    Eigen::Vector3i corners;
    std::uint32_t material = 0;
    std::uint16_t part = 0;
    std::uint16_t instance = 0;
    float light_spacing_m = 0;
    Eigen::Vector3f mean_color{0, 0, 0};  ///< Reflectance, or emission where the material emits.
    bool lets_light_in = false;
  };
  struct Hit {
    std::uint32_t triangle = 0;
    float distance = -1;  ///< [m], negative for none
    float u = 0, v = 0;   ///< Barycentric weights of corners 1 and 2.
    bool valid() const { return distance >= 0; }
  };

  explicit TracedScene(std::span<const RoomPart> parts);
  ~TracedScene();
  TracedScene(const TracedScene&) = delete;
  TracedScene& operator=(const TracedScene&) = delete;

  /// `direction` has unit length.
  Hit Trace(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;
  /// Four rays at once from one origin each; faster where they stay close together.
  std::array<Hit, 4> Trace4(const std::array<Eigen::Vector3f, 4>& origins,
                            const std::array<Eigen::Vector3f, 4>& directions) const;
  /// Whether something that casts shadows lies on the way.
  bool Blocked(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
               float distance) const;

  const std::vector<Triangle>& triangles() const { return triangles_; }
  const std::vector<Eigen::Vector3f>& vertices() const { return vertices_; }
  const Material& material(const Triangle& triangle) const { return materials_[triangle.material]; }
  Eigen::Vector3f ShadingNormal(const Hit& hit) const {
    return Interpolate(normals_, hit).normalized();
  }
  Eigen::Vector3f ShadingNormalAt(int vertex) const {
    return normals_[static_cast<std::size_t>(vertex)];
  }
  Eigen::Vector3f FaceNormal(std::uint32_t triangle) const;
  Eigen::Vector3f Texture(const Hit& hit) const { return Interpolate(texture_, hit); }

 private:
  struct Embree;
  Eigen::Vector3f Interpolate(const std::vector<Eigen::Vector3f>& values, const Hit& hit) const {
    const Eigen::Vector3i& c = triangles_[hit.triangle].corners;
    return values[static_cast<std::size_t>(c[0])] * (1 - hit.u - hit.v) +
           values[static_cast<std::size_t>(c[1])] * hit.u +
           values[static_cast<std::size_t>(c[2])] * hit.v;
  }
  void AddPart(const RoomPart& part, std::uint16_t index);

  std::vector<Eigen::Vector3f> vertices_, normals_, texture_;
  std::vector<Triangle> triangles_;
  std::vector<Material> materials_;
  std::uint32_t first_pane_ = 0;  ///< Triangles from here on let light in.
  std::unique_ptr<Embree> embree_;
};

}  // namespace plumbline
