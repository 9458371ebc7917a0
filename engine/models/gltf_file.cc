// SPDX-License-Identifier: Apache-2.0
#include "engine/models/gltf_file.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/geometry/distinct_color.h"

namespace plumbline {
namespace {

// Numbers of the specification (glTF 2.0, sections 3.6 and 4.4).
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementBuffer = 34963;
constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;

/// From sRGB, as pictures and scans have colours, to the linear values that glTF wants.
double Linear(std::uint8_t value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

nlohmann::json Numbers(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

template <typename T>
void Put(const T& value, std::string& out) {
  static_assert(std::endian::native == std::endian::little);
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

/// The file as it grows.
class Gltf {
 public:
  void Add(const GltfObject& object, int number) {
    nlohmann::json extras = object.extras;
    Eigen::Quaterniond q(object.room_from_object.linear());
    const Eigen::Vector3d t = object.room_from_object.translation();
    nodes_.push_back({{"name", object.name},
                      {"mesh", MeshOf(object, number)},
                      {"translation", {t.x(), t.y(), t.z()}},
                      {"rotation", {q.x(), q.y(), q.z(), q.w()}},
                      {"scale", {object.scale, object.scale, object.scale}}});
    extras["model"] = object.model->name;
    extras["category"] = object.model->category;
    nodes_.back()["extras"] = std::move(extras);
  }

  std::string Bytes(GltfUp up) {
    nlohmann::json children = nlohmann::json::array();
    for (std::size_t i = 0; i < nodes_.size(); ++i) children.push_back(i);
    nlohmann::json room = {{"name", "room"}, {"children", std::move(children)}};
    const double half = std::sqrt(0.5);  // a quarter turn about x: (x, y, z) -> (x, z, -y)
    if (up == GltfUp::kY) room["rotation"] = {-half, 0, 0, half};
    nodes_.push_back(std::move(room));
    nlohmann::json json = {{"asset", {{"version", "2.0"}, {"generator", "Plumbline"}}},
                           {"scene", 0},
                           {"scenes", {{{"name", "room"}, {"nodes", {nodes_.size() - 1}}}}},
                           {"nodes", nodes_},
                           {"meshes", meshes_},
                           {"materials", materials_},
                           {"accessors", accessors_},
                           {"bufferViews", views_},
                           {"buffers", {{{"byteLength", binary_.size()}}}}};
    for (const auto& [key, list] :
         {std::pair("textures", &textures_), std::pair("images", &images_)}) {
      if (!list->empty()) json[key] = *list;
    }
    std::string text = JsonText(json);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string out;
    Put(kMagic, out);
    Put(std::uint32_t{2}, out);
    Put(static_cast<std::uint32_t>(28 + text.size() + binary_.size()), out);
    for (const auto& [kind, chunk] :
         {std::pair(kJsonChunk, &text), std::pair(kBinChunk, &binary_)}) {
      Put(static_cast<std::uint32_t>(chunk->size()), out);
      Put(kind, out);
      out += *chunk;
    }
    return out;
  }

  /// Embeds the picture; nothing is done for a second object with it. Errors: kNotFound, kIo.
  Status AddTexture(const std::filesystem::path& file) {
    if (file.empty() || texture_numbers_.contains(file)) return {};
    const Result<std::string> picture = ReadFile(file);
    if (!picture) return picture.error();
    const bool png = picture->starts_with("\x89PNG");
    images_.push_back({{"name", file.stem().string()},
                       {"mimeType", png ? "image/png" : "image/jpeg"},
                       {"bufferView", AddView(*picture, 0)}});
    texture_numbers_[file] = static_cast<int>(textures_.size());
    textures_.push_back({{"source", images_.size() - 1}});
    return {};
  }

 private:
  /// @param target  0: none.
  int AddView(const std::string& bytes, int target) {
    views_.push_back({{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes.size()}});
    if (target != 0) views_.back()["target"] = target;
    binary_ += bytes;
    binary_.resize((binary_.size() + 3) / 4 * 4, '\0');
    return static_cast<int>(views_.size()) - 1;
  }
  int AddAccessor(const std::string& bytes, std::size_t count, const char* type, int component,
                  int target = kArrayBuffer) {
    accessors_.push_back({{"bufferView", AddView(bytes, target)},
                          {"componentType", component},
                          {"count", count},
                          {"type", type}});
    return static_cast<int>(accessors_.size()) - 1;
  }

  /// Attributes and indices of a model, written once.
  const nlohmann::json& GeometryOf(const CadModel& model, bool textured) {
    const auto [found, added] = geometry_.try_emplace(&model);
    if (!added) return found->second;
    TriangleMesh mesh = model.mesh;
    if (mesh.normals.empty()) ComputeNormals(mesh);
    std::string places, normals, colors, uvs, indices;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      for (int c = 0; c < 3; ++c) Put(mesh.vertices[i][c], places);
      const float length = mesh.normals[i].norm();
      const Eigen::Vector3f normal =
          length > 0 ? Eigen::Vector3f(mesh.normals[i] / length) : Eigen::Vector3f(0, 0, 1);
      for (int c = 0; c < 3; ++c) Put(normal[c], normals);
    }
    // They would tint the texture, of which they are a coarse copy.
    if (textured) mesh.colors.clear();
    for (const auto& color : mesh.colors) {
      for (const std::uint8_t c : color)
        Put(static_cast<std::uint16_t>(std::lround(65535 * Linear(c))), colors);
      Put(std::uint16_t{65535}, colors);
    }
    for (const Eigen::Vector2f& uv : mesh.texture_coordinates) {
      Put(uv.x(), uvs);
      Put(1 - uv.y(), uvs);  // glTF counts from the upper edge
    }
    for (const Eigen::Vector3i& triangle : mesh.triangles) {
      for (int c = 0; c < 3; ++c) Put(static_cast<std::uint32_t>(triangle[c]), indices);
    }
    const std::size_t count = mesh.vertices.size();
    nlohmann::json& geometry = found->second;
    geometry["attributes"]["POSITION"] = AddAccessor(places, count, "VEC3", kFloat);
    accessors_.back()["min"] = Numbers(model.bounds.min());
    accessors_.back()["max"] = Numbers(model.bounds.max());
    geometry["attributes"]["NORMAL"] = AddAccessor(normals, count, "VEC3", kFloat);
    if (!colors.empty())
      geometry["attributes"]["COLOR_0"] = AddAccessor(colors, count, "VEC4", kUnsignedShort);
    if (!uvs.empty())
      geometry["attributes"]["TEXCOORD_0"] = AddAccessor(uvs, count, "VEC2", kFloat);
    geometry["indices"] =
        AddAccessor(indices, 3 * mesh.triangles.size(), "SCALAR", kUnsignedInt, kElementBuffer);
    return geometry;
  }

  int MeshOf(const GltfObject& object, int number) {
    nlohmann::json surface = {{"metallicFactor", 0}, {"roughnessFactor", 0.8}};
    const auto texture = texture_numbers_.find(object.texture);
    const bool textured = texture != texture_numbers_.end();
    if (textured) {
      surface["baseColorTexture"] = {{"index", texture->second}};
    } else if (object.model->mesh.colors.empty()) {
      const auto [red, green, blue] = DistinctColor(number);
      surface["baseColorFactor"] = {Linear(red), Linear(green), Linear(blue), 1};
    }
    materials_.push_back({{"name", object.name},
                          {"pbrMetallicRoughness", std::move(surface)},
                          {"doubleSided", true}});
    nlohmann::json primitive = GeometryOf(*object.model, textured);
    primitive["material"] = materials_.size() - 1;
    meshes_.push_back(
        {{"name", object.model->name}, {"primitives", nlohmann::json::array({primitive})}});
    return static_cast<int>(meshes_.size()) - 1;
  }

  std::string binary_;
  nlohmann::json nodes_ = nlohmann::json::array(), meshes_ = nlohmann::json::array(),
                 materials_ = nlohmann::json::array(), accessors_ = nlohmann::json::array(),
                 views_ = nlohmann::json::array(), textures_ = nlohmann::json::array(),
                 images_ = nlohmann::json::array();
  std::map<const CadModel*, nlohmann::json> geometry_;
  std::map<std::filesystem::path, int> texture_numbers_;
};

}  // namespace

Status WriteGltf(const std::filesystem::path& file, std::span<const GltfObject> objects,
                 GltfUp up) {
  if (file.extension() != ".glb") {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() +
                                               "' must end in .glb: binary glTF is written, in "
                                               "one file"};
  }
  if (objects.empty()) {
    return Error{ErrorCode::kInvalidInput,
                 "there are no objects that '" + file.string() + "' could hold"};
  }
  Gltf gltf;
  int number = 0;
  for (const GltfObject& object : objects) {
    PLB_CHECK(object.model != nullptr) << "an object without a model";
    if (const Status added = gltf.AddTexture(object.texture); !added.ok()) return added;
    gltf.Add(object, number++);
  }
  return WriteFileAtomically(file, gltf.Bytes(up));
}

}  // namespace plumbline
