// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/room_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/models/mesh_file.h"
#include "engine/synthetic/film.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

/// Vertices of one part closer than this become one, which melts roundings and thin blades.
constexpr float kMergeM = 0.005f;

std::uint64_t PlaceKey(const Vector3f& position, std::uint16_t part) {
  std::uint64_t key = part;
  for (int axis = 0; axis < 3; ++axis) {
    key =
        key * 4000037 + static_cast<std::uint64_t>(std::llround(position[axis] / kMergeM) + 100000);
  }
  return key;
}

/// Cuts one triangle of the scene into small ones and adds them to a scan.
class ScanBuilder {
 public:
  ScanBuilder(const RayTracer& tracer, float spacing_m) : tracer_(tracer), spacing_m_(spacing_m) {}

  void Add(std::uint32_t triangle) {
    triangle_ = triangle;
    Split({0, 0}, {1, 0}, {0, 1});
  }
  TriangleMesh Take() { return std::move(scan_); }

 private:
  using Weights = Eigen::Vector2f;  ///< Barycentric, of corners 1 and 2.

  Vector3f At(const Weights& w) const {
    const TracedScene& scene = tracer_.scene();
    const Eigen::Vector3i& c = scene.triangles()[triangle_].corners;
    const Vector3f& a = scene.vertices()[static_cast<std::size_t>(c[0])];
    return a + w.x() * (scene.vertices()[static_cast<std::size_t>(c[1])] - a) +
           w.y() * (scene.vertices()[static_cast<std::size_t>(c[2])] - a);
  }

  /// Halves the longest edge until all are short; neighbours cut their shared edge alike.
  void Split(const Weights& a, const Weights& b, const Weights& c) {
    const float ab = (At(a) - At(b)).norm(), bc = (At(b) - At(c)).norm(),
                ca = (At(c) - At(a)).norm();
    const float longest = std::max({ab, bc, ca});
    if (longest <= spacing_m_) {
      // New vertices are numbered as they are asked for, which the order of arguments leaves open.
      const int third = Vertex(c), second = Vertex(b), first = Vertex(a);
      Emit(first, second, third);
    } else if (ab == longest) {
      Halve(a, b, c);
    } else if (bc == longest) {
      Halve(b, c, a);
    } else {
      Halve(c, a, b);
    }
  }
  void Halve(const Weights& a, const Weights& b, const Weights& c) {
    const Weights middle = 0.5f * (a + b);
    Split(a, middle, c);
    Split(middle, b, c);
  }

  int Vertex(const Weights& w) {
    const Vector3f position = At(w);
    const std::uint16_t part = tracer_.scene().triangles()[triangle_].part;
    const auto [entry, fresh] =
        known_.try_emplace(PlaceKey(position, part), static_cast<int>(scan_.vertices.size()));
    if (fresh) {
      const Vector3f color = tracer_.ScannedColor({triangle_, 0, w.x(), w.y()}, spacing_m_);
      std::array<std::uint8_t, 3> rgb;
      for (int k = 0; k < 3; ++k) {
        const float shown = EncodeSrgb(ToneCurve(color[k] * tracer_.exposure()));
        rgb[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(std::lround(255 * shown));
      }
      scan_.vertices.push_back(position);
      scan_.colors.push_back(rgb);
    }
    return entry->second;
  }

  void Emit(int a, int b, int c) {
    if (a != b && b != c && a != c) scan_.triangles.emplace_back(a, b, c);
  }

  const RayTracer& tracer_;
  float spacing_m_;
  std::uint32_t triangle_ = 0;
  TriangleMesh scan_;
  std::unordered_map<std::uint64_t, int> known_;
};

}  // namespace

TriangleMesh ScanOfRoom(const Room& room, const RayTracer& tracer, float spacing_m) {
  ScanBuilder builder(tracer, spacing_m);
  const auto& triangles = tracer.scene().triangles();
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (room.parts[triangles[t].part].in_scan) builder.Add(t);
  }
  return builder.Take();
}

Status WriteModels(const std::filesystem::path& folder,
                   const std::vector<FurnitureModel>& catalogue) {
  nlohmann::json models = nlohmann::json::array();
  for (const FurnitureModel& model : catalogue) {
    const TriangleMesh mesh = Scaled(DatabaseMesh(model.body), 1 / model.scale);
    const Status written = WritePly(folder / (model.name + ".ply"), mesh);
    if (!written.ok()) return written;
    models.push_back({{"name", model.name},
                      {"file", model.name + ".ply"},
                      {"category", model.category},
                      {"symmetry", {{"axis", {0, 0, 1}}, {"order", model.symmetry_order}}},
                      {"support", model.support == Support::kFloor ? "floor" : "any"},
                      {"back", model.back},
                      {"faces", mesh.triangles.size()},
                      {"note", model.note}});
  }
  return WriteJson(folder / "models.json", {{"units", "m"}, {"models", models}});
}

}  // namespace plumbline
