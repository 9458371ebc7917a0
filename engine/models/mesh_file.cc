// SPDX-License-Identifier: Apache-2.0
#include "engine/models/mesh_file.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <string>
#include <utility>

#include "engine/base/data_paths.h"
#include "engine/base/files.h"
#include "engine/models/assimp_file.h"
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

/// Whose colours say nothing: they are those of a PLY that was made from a texture.
bool AllWhite(const TriangleMesh& mesh) {
  return std::all_of(mesh.colors.begin(), mesh.colors.end(), [](const auto& rgb) {
    return rgb[0] == 255 && rgb[1] == 255 && rgb[2] == 255;
  });
}

/// A PLY with colours shows these: models that were built from a texture have it painted on.
void ReadPlyTexture(const std::filesystem::path& file, TexturedMesh& read) {
  TriangleMesh& mesh = read.mesh;
  if (mesh.texture_file.empty() || mesh.triangles.empty() || !AllWhite(mesh)) return;
  if (const auto place = PlaceInside(file.parent_path(), mesh.texture_file); !place.ok()) {
    read.warnings.push_back("its texture is left out: " + place.error().message);
    mesh.texture_file.clear();
    return;
  }
  const std::filesystem::path picture = FindPicture(file, mesh.texture_file);
  if (!picture.empty()) {
    if (Result<std::string> bytes = ReadFile(picture); bytes.ok())
      read.texture = DecodePicture(std::move(*bytes));
  }
  if (!read.texture.empty()) return;
  read.warnings.push_back("its texture '" + (file.parent_path() / mesh.texture_file).string() +
                          "' is missing or no picture that can be read, and left out");
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

bool IsMeshName(const std::filesystem::path& file) {
  const std::string extension = LowerExtension(file);
  return extension == ".ply" || extension == ".pcd" || AssimpReads(extension);
}

Result<TexturedMesh> ReadTexturedMesh(const std::filesystem::path& file) {
  const std::string extension = LowerExtension(file);
  if (extension == ".ply" || extension == ".pcd") {
    Result<std::string> bytes = ReadFile(file);
    if (!bytes.ok()) return bytes.error();
    Result<TriangleMesh> mesh =
        extension == ".ply" ? ParsePly(*bytes, file) : ParsePcd(*bytes, file);
    if (!mesh.ok()) return mesh.error();
    TexturedMesh read;
    read.mesh = std::move(*mesh);
    ReadPlyTexture(file, read);
    return read;
  }
  if (!AssimpReads(extension)) {
    return Error{ErrorCode::kUnsupported, "'" + file.string() +
                                              "' is no mesh file that Plumbline reads (ply, pcd, " +
                                              AssimpEndings() + ")"};
  }
  Result<TexturedMesh> read = ReadByAssimp(file);
  if (!read.ok()) return read;
  if (const Status status = CheckMesh(read->mesh, file); !status.ok()) return status.error();
  return read;
}

Result<TriangleMesh> ReadMesh(const std::filesystem::path& file, int added_faces) {
  Result<TexturedMesh> read = ReadTexturedMesh(file);
  if (!read.ok()) return read.error();
  if (!read->texture.empty() && added_faces > 0) {
    const int faces = static_cast<int>(read->mesh.triangles.size());
    PaintByTexture(read->texture, faces + added_faces, read->mesh);
  } else if (!read->texture.empty()) {
    PaintVertices(read->texture, read->mesh);
  }
  // One that was put together or lay inside of the file is nowhere to be found later.
  if (!read->texture.empty() && read->mesh.texture_file.empty())
    read->mesh.texture_coordinates.clear();
  if (read->frame.metres) {
    for (Eigen::Vector3f& vertex : read->mesh.vertices)
      vertex *= static_cast<float>(*read->frame.metres);
  }
  return std::move(read->mesh);
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
