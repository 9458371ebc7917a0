// SPDX-License-Identifier: Apache-2.0
#include "engine/models/assimp_file.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/base/files.h"
#include "engine/models/assimp_check.h"

namespace plumbline {
namespace {

std::string InLowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string EndingOf(const std::filesystem::path& file) {
  return InLowerCase(file.extension().string());
}

bool IsGltf(const std::string& ending) { return ending == ".gltf" || ending == ".glb"; }

std::uint8_t Level(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

/// glTF's numbers are linear, pictures and colours on disk are not (IEC 61966-2-1).
float Encoded(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

aiColor4D Encoded(aiColor4D color) {
  return {Encoded(color.r), Encoded(color.g), Encoded(color.b), color.a};
}

/// Of one file.
class AssimpReader {
 public:
  explicit AssimpReader(const std::filesystem::path& file) : file_(file), ending_(EndingOf(file)) {}

  Result<TexturedMesh> Read() {
    if (const Status status = CheckBeforeAssimp(file_, ending_); !status.ok())
      return status.error();
    Assimp::Importer importer;
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                                aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, ending_ == ".dae");
    scene_ = importer.ReadFile(file_.string(), aiProcess_Triangulate | aiProcess_SortByPType |
                                                   aiProcess_PreTransformVertices |
                                                   aiProcess_JoinIdenticalVertices |
                                                   aiProcess_TransformUVCoords);
    if (scene_ == nullptr) {
      return Error{ErrorCode::kCorrupt, "cannot read a mesh from '" + file_.string() +
                                            "': " + importer.GetErrorString()};
    }
    std::vector<TexturePart> parts;
    for (unsigned i = 0; i < scene_->mNumMeshes; ++i)
      parts.push_back(ReadPart(*scene_->mMeshes[i]));
    TexturedMesh read = JoinParts(std::move(parts), textures_);
    if (textures_.size() == 1 && read.texture.data == textures_[0].data)
      read.mesh.texture_file = texture_files_[0];
    read.frame = Frame();
    read.warnings = std::move(warnings_);
    if (ending_ == ".dae" && read.frame.metres) {  // assimp has applied it
      for (Eigen::Vector3f& vertex : read.mesh.vertices)
        vertex /= static_cast<float>(*read.frame.metres);
    }
    return read;
  }

 private:
  /// Colours of the vertices, else that of the material if the file gives one. With a texture
  /// only glTF means both at once; elsewhere the texture takes their place.
  void ReadColors(const aiMesh& part, const aiMaterial& material, TexturePart& read) const {
    const bool gltf = IsGltf(ending_), textured = read.texture >= 0;
    if (textured && !gltf) return;
    aiString name;
    aiColor4D diffuse(1, 1, 1, 1);
    const bool has_diffuse = material.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS &&
                             std::string(name.C_Str()) != AI_DEFAULT_MATERIAL_NAME &&
                             material.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse) == aiReturn_SUCCESS;
    if (!part.HasVertexColors(0) &&
        (!has_diffuse || (textured && diffuse == aiColor4D(1, 1, 1, 1))))
      return;
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      aiColor4D color = part.HasVertexColors(0) ? part.mColors[0][i] : diffuse;
      if (gltf && part.HasVertexColors(0)) color = color * diffuse;
      if (gltf) color = Encoded(color);
      read.mesh.colors.push_back({Level(color.r), Level(color.g), Level(color.b)});
    }
  }

  TexturePart ReadPart(const aiMesh& part) {
    TexturePart read;
    TriangleMesh& mesh = read.mesh;
    const aiMaterial& material = *scene_->mMaterials[part.mMaterialIndex];
    unsigned channel = 0;
    read.texture = TextureOf(material, channel);
    if (channel >= AI_MAX_NUMBER_OF_TEXTURECOORDS || !part.HasTextureCoords(channel)) {
      read.texture = -1;
      channel = 0;
    }
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      mesh.vertices.emplace_back(part.mVertices[i].x, part.mVertices[i].y, part.mVertices[i].z);
      if (part.HasNormals())
        mesh.normals.emplace_back(part.mNormals[i].x, part.mNormals[i].y, part.mNormals[i].z);
      if (!part.HasTextureCoords(channel)) continue;
      const aiVector3D& uv = part.mTextureCoords[channel][i];
      const Eigen::Vector2f coordinates(uv.x, uv.y);
      mesh.texture_coordinates.push_back(coordinates.allFinite() ? coordinates
                                                                 : Eigen::Vector2f(0, 0));
    }
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;
      mesh.triangles.emplace_back(static_cast<int>(face.mIndices[0]),
                                  static_cast<int>(face.mIndices[1]),
                                  static_cast<int>(face.mIndices[2]));
    }
    ReadColors(part, material, read);
    return read;
  }

  /// Its place in `textures_`; -1: the material has none that can be read.
  int TextureOf(const aiMaterial& material, unsigned& channel) {
    aiString name;
    const auto has = [&](aiTextureType type) {
      return material.GetTexture(type, 0, &name, nullptr, &channel) == aiReturn_SUCCESS;
    };
    if (!has(aiTextureType_BASE_COLOR) && !has(aiTextureType_DIFFUSE)) return -1;
    const auto [known, is_new] = known_.try_emplace(name.C_Str(), -1);
    if (!is_new) return known->second;
    std::string where;
    const cv::Mat picture = ReadTexture(name.C_Str(), where);
    if (picture.empty()) return -1;
    textures_.push_back(picture);
    texture_files_.push_back(where);
    return known->second = static_cast<int>(textures_.size()) - 1;
  }

  /// `where`: relative to the mesh; "" for one inside of it.
  cv::Mat ReadTexture(const std::string& name, std::string& where) {
    if (const aiTexture* inside = scene_->GetEmbeddedTexture(name.c_str()); inside != nullptr) {
      cv::Mat picture;
      if (inside->mHeight > 0) {
        cv::cvtColor(cv::Mat(static_cast<int>(inside->mHeight), static_cast<int>(inside->mWidth),
                             CV_8UC4, inside->pcData),
                     picture, cv::COLOR_BGRA2BGR);
      } else {
        picture = DecodePicture({reinterpret_cast<const char*>(inside->pcData),
                                 static_cast<std::size_t>(inside->mWidth)});
      }
      if (picture.empty())
        warnings_.push_back(
            "the texture inside of it is no picture that can be read, and left out");
      return picture;
    }
    const std::filesystem::path file = FindPicture(file_, name);
    if (file.empty()) {
      warnings_.push_back("its texture '" + (file_.parent_path() / name).string() +
                          "' is missing and left out");
      return {};
    }
    Result<std::string> bytes = ReadFile(file);
    const cv::Mat picture = bytes.ok() ? DecodePicture(std::move(*bytes)) : cv::Mat();
    if (picture.empty()) {
      warnings_.push_back("its texture '" + file.string() +
                          "' is no picture that can be read, and left out");
    }
    where = file.lexically_proximate(file_.parent_path()).string();
    return picture;
  }

  FileFrame Frame() const {
    if (IsGltf(ending_)) return {1.0, SignedAxis{1, 1}, "the glTF format"};
    if (ending_ == ".x3d" || ending_ == ".x3db") return {1.0, SignedAxis{1, 1}, "the X3D format"};
    if (ending_ == ".3ds")
      return {std::nullopt, SignedAxis{1, 1}, "assimp, which turns 3DS files,"};
    if (ending_ == ".dae") return ColladaFrame();
    if (ending_ == ".zae") return {1.0, SignedAxis{1, 1}, "assimp, which turns ZAE files,"};
    if (ending_ == ".fbx") return FbxFrame();
    return {};
  }

  /// <unit meter="0.01"> and <up_axis> of the asset; 1 and Y_UP by definition (COLLADA 1.4.1,
  /// "asset").
  FileFrame ColladaFrame() const {
    FileFrame frame{1.0, SignedAxis{1, 1}, "the COLLADA file"};
    const Result<std::string> text = ReadFile(file_);
    if (!text.ok()) return frame;
    const std::size_t begin = text->find("<asset"), end = text->find("</asset>");
    if (begin == std::string::npos || end == std::string::npos || end < begin) return frame;
    const std::string asset = text->substr(begin, end - begin);
    const std::size_t unit = asset.find("<unit");
    const std::size_t metres = unit == std::string::npos ? unit : asset.find("meter=", unit);
    if (metres != std::string::npos && metres + 7 < asset.size()) {
      const double value = std::strtod(asset.c_str() + metres + 7, nullptr);
      if (std::isfinite(value) && value > 0) frame.metres = value;
    }
    if (asset.find("X_UP") != std::string::npos) frame.up = SignedAxis{0, 1};
    if (asset.find("Z_UP") != std::string::npos) frame.up = SignedAxis{2, 1};
    return frame;
  }

  FileFrame FbxFrame() const {
    FileFrame frame;
    frame.by = "the FBX file";
    int axis = 1, sign = 1;
    double centimetres = 1;
    const aiMetadata* data = scene_->mMetaData;
    if (data == nullptr) return frame;
    if (data->Get("UpAxis", axis) && data->Get("UpAxisSign", sign) && axis >= 0 && axis < 3)
      frame.up = SignedAxis{axis, sign < 0 ? -1 : 1};
    float single = 1;
    const bool stated = data->Get("UnitScaleFactor", centimetres) ||
                        (data->Get("UnitScaleFactor", single) && (centimetres = single, true));
    if (stated && std::isfinite(centimetres) && centimetres > 0) frame.metres = 0.01 * centimetres;
    return frame;
  }

  const std::filesystem::path& file_;
  std::string ending_;
  const aiScene* scene_ = nullptr;
  std::vector<cv::Mat> textures_;
  std::vector<std::string> texture_files_;
  std::map<std::string, int> known_;  ///< Of each name, its place there.
  std::vector<std::string> warnings_;
};

}  // namespace

bool AssimpReads(const std::string& extension) {
  static const std::set<std::string> known = [] {
    std::set<std::string> endings;
    aiString list;
    Assimp::Importer().GetExtensionList(list);
    std::istringstream stream(list.C_Str());  // "*.3ds;*.dae"
    for (std::string ending; std::getline(stream, ending, ';');) endings.insert(ending.substr(1));
    return endings;
  }();
  return known.contains(extension);
}

std::string AssimpEndings() {
  aiString list;
  Assimp::Importer().GetExtensionList(list);
  std::string endings;  // "*.3ds;*.dae" is said as "3ds, dae"
  for (const char c : std::string(list.C_Str())) {
    if (c == ';') endings += ", ";
    if (c != '*' && c != ';' && !(c == '.' && (endings.empty() || endings.back() == ' ')))
      endings += c;
  }
  return endings;
}

std::filesystem::path FindPicture(const std::filesystem::path& mesh_file, const std::string& name) {
  std::string forward = name;  // files made on Windows
  std::replace(forward.begin(), forward.end(), '\\', '/');
  const std::filesystem::path folder = mesh_file.parent_path(), said(forward);
  std::error_code ignored;
  for (const std::filesystem::path& wanted :
       {folder / said, folder / said.filename(), folder / "textures" / said.filename()}) {
    if (std::filesystem::is_regular_file(wanted, ignored)) return wanted;
    const std::filesystem::path parent = wanted.parent_path().empty() ? "." : wanted.parent_path();
    for (const auto& entry : std::filesystem::directory_iterator(parent, ignored)) {
      if (InLowerCase(entry.path().filename().string()) ==
              InLowerCase(wanted.filename().string()) &&
          entry.is_regular_file(ignored)) {
        return entry.path();
      }
    }
  }
  return {};
}

Result<TexturedMesh> ReadByAssimp(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) {
    return Error{ErrorCode::kNotFound, "there is no mesh file '" + file.string() + "'"};
  }
  return AssimpReader(file).Read();
}

}  // namespace plumbline
