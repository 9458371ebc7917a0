// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/base/result.h"
#include "engine/models/textured_mesh.h"

namespace plumbline {

/// Whether assimp reads files of this ending (".dae", in lower case).
bool AssimpReads(const std::string& extension);

/// The endings of these files, for people: "3ds, dae, fbx, ..".
std::string AssimpEndings();

/// Nodes are placed by their matrices. glTF, X3D: what they are in is defined by the format;
/// COLLADA, FBX: the file states it; 3DS: assimp turns them y up. Textures lie inside of the file,
/// beside it or where it says. Errors: kNotFound, kCorrupt.
Result<TexturedMesh> ReadByAssimp(const std::filesystem::path& file);

/// The picture `name` that a mesh file asks for: where it says, else in its folder or the folder
/// `textures` there, in capitals or not. Empty path: nowhere.
std::filesystem::path FindPicture(const std::filesystem::path& mesh_file, const std::string& name);

}  // namespace plumbline
