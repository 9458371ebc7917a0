// SPDX-License-Identifier: Apache-2.0
#include "engine/models/mesh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <bit>
#include <cctype>
#include <cmath>
#include <string>

#include "engine/base/files.h"
#include "engine/models/pcd_file.h"
#include "engine/models/ply_file.h"

namespace plumbline {
namespace {

std::string LowerExtension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

std::uint8_t Level(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

/// Colours of the vertices, else that of the material if the file gives one.
void ReadColors(const aiMesh& part, const aiMaterial& material, TriangleMesh& mesh) {
  aiString name;
  aiColor4D diffuse;
  if (part.HasVertexColors(0)) {
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiColor4D& color = part.mColors[0][i];
      mesh.colors.push_back({Level(color.r), Level(color.g), Level(color.b)});
    }
  } else if (material.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS &&
             std::string(name.C_Str()) != AI_DEFAULT_MATERIAL_NAME &&
             material.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse) == aiReturn_SUCCESS) {
    mesh.colors.assign(part.mNumVertices, {Level(diffuse.r), Level(diffuse.g), Level(diffuse.b)});
  }
}

TriangleMesh ReadPart(const aiMesh& part, const aiMaterial& material) {
  TriangleMesh mesh;
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    mesh.vertices.emplace_back(part.mVertices[i].x, part.mVertices[i].y, part.mVertices[i].z);
    if (part.HasNormals())
      mesh.normals.emplace_back(part.mNormals[i].x, part.mNormals[i].y, part.mNormals[i].z);
    if (part.HasTextureCoords(0)) {
      mesh.texture_coordinates.emplace_back(part.mTextureCoords[0][i].x,
                                            part.mTextureCoords[0][i].y);
    }
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) continue;
    mesh.triangles.emplace_back(static_cast<int>(face.mIndices[0]),
                                static_cast<int>(face.mIndices[1]),
                                static_cast<int>(face.mIndices[2]));
  }
  ReadColors(part, material, mesh);
  aiString texture;
  const bool has_texture =
      material.GetTexture(aiTextureType_BASE_COLOR, 0, &texture) == aiReturn_SUCCESS ||
      material.GetTexture(aiTextureType_DIFFUSE, 0, &texture) == aiReturn_SUCCESS;
  // A texture inside the file ("*0") has no name of its own.
  if (has_texture && part.HasTextureCoords(0) && texture.C_Str()[0] != '*')
    mesh.texture_file = texture.C_Str();
  return mesh;
}

Result<TriangleMesh> ReadWithAssimp(const std::filesystem::path& file) {
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(
      file.string(), aiProcess_Triangulate | aiProcess_SortByPType |
                         aiProcess_PreTransformVertices | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr) {
    return Error{ErrorCode::kCorrupt,
                 "cannot read a mesh from '" + file.string() + "': " + importer.GetErrorString()};
  }
  TriangleMesh mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
    const aiMesh& part = *scene->mMeshes[i];
    TriangleMesh read = ReadPart(part, *scene->mMaterials[part.mMaterialIndex]);
    if (mesh.empty()) {
      mesh = std::move(read);
    } else {
      Append(read, mesh);
    }
  }
  return mesh;
}

Status CheckMesh(const TriangleMesh& mesh, const std::filesystem::path& file) {
  const auto corrupt = [&file](const std::string& what) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' is damaged: " + what};
  };
  if (mesh.vertices.empty()) return corrupt("it holds no vertices");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite())
      return corrupt("vertex " + std::to_string(i) + " is not finite");
  }
  const int count = static_cast<int>(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangles[i].minCoeff() < 0 || mesh.triangles[i].maxCoeff() >= count) {
      return corrupt("face " + std::to_string(i) + " names a vertex that is not there");
    }
  }
  return {};
}

template <typename T>
void PutBytes(std::string& out, const T* values, std::size_t count) {
  static_assert(std::endian::native == std::endian::little);
  out.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

std::string PlyHeaderOf(const TriangleMesh& mesh) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (!mesh.texture_file.empty()) header += "comment TextureFile " + mesh.texture_file + "\n";
  header += "element vertex " + std::to_string(mesh.vertices.size()) +
            "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!mesh.normals.empty()) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.colors.empty())
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (!mesh.texture_coordinates.empty()) header += "property float s\nproperty float t\n";
  if (!mesh.triangles.empty()) {
    header += "element face " + std::to_string(mesh.triangles.size()) +
              "\nproperty list uchar int vertex_indices\n";
  }
  return header + "end_header\n";
}

}  // namespace

Result<TriangleMesh> ReadMesh(const std::filesystem::path& file) {
  const std::string extension = LowerExtension(file);
  if (extension == ".ply") {
    Result<std::string> bytes = ReadFile(file);
    if (!bytes.ok()) return bytes.error();
    return ParsePly(*bytes, file);
  }
  if (extension == ".pcd") {
    Result<std::string> bytes = ReadFile(file);
    if (!bytes.ok()) return bytes.error();
    return ParsePcd(*bytes, file);
  }
  if (extension != ".obj" && extension != ".glb" && extension != ".gltf" && extension != ".stl") {
    return Error{ErrorCode::kUnsupported,
                 "'" + file.string() +
                     "' is no mesh file that Plumbline reads (PLY, PCD, OBJ, GLB, GLTF, STL)"};
  }
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) {
    return Error{ErrorCode::kNotFound, "there is no mesh file '" + file.string() + "'"};
  }
  Result<TriangleMesh> mesh = ReadWithAssimp(file);
  if (!mesh.ok()) return mesh;
  if (const Status status = CheckMesh(*mesh, file); !status.ok()) return status.error();
  return mesh;
}

Status WritePly(const std::filesystem::path& file, const TriangleMesh& mesh) {
  const std::size_t count = mesh.vertices.size();
  PLB_CHECK(mesh.normals.empty() || mesh.normals.size() == count) << "normals of another length";
  PLB_CHECK(mesh.colors.empty() || mesh.colors.size() == count) << "colours of another length";
  PLB_CHECK(mesh.texture_coordinates.empty() || mesh.texture_coordinates.size() == count)
      << "texture of another length";
  std::string out = PlyHeaderOf(mesh);
  out.reserve(out.size() + count * 35 + mesh.triangles.size() * 13);
  for (std::size_t i = 0; i < count; ++i) {
    PutBytes(out, mesh.vertices[i].data(), 3);
    if (!mesh.normals.empty()) PutBytes(out, mesh.normals[i].data(), 3);
    if (!mesh.colors.empty()) PutBytes(out, mesh.colors[i].data(), 3);
    if (!mesh.texture_coordinates.empty()) PutBytes(out, mesh.texture_coordinates[i].data(), 2);
  }
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    out.push_back(3);
    PutBytes(out, triangle.data(), 3);
  }
  return WriteFileAtomically(file, out);
}

}  // namespace plumbline
