// SPDX-License-Identifier: Apache-2.0
// Meshes and databases of models.
#include <array>
#include <string>

#include "engine/models/instance_crop.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_check.h"
#include "engine/models/model_database.h"
#include "engine/models/model_source.h"
#include "engine/models/pcd_file.h"
#include "engine/models/ply_file.h"
#include "engine/models/scan_file.h"
#include "tests/fuzz/fuzz_targets.h"

namespace plumbline::fuzz {
namespace {

Status Ply(std::string_view input) {
  std::size_t left_out = 0;
  (void)ParsePly(input, "mesh.ply", &left_out);
  const auto file = FileOf("mesh.ply", input);
  if (const auto scan = ReadLabelledMesh(file); scan.ok())
    (void)UprightModel(CropByLabel(*scan, 7), {0, 0, -1});
  return StatusOf(ReadMesh(file));
}

Status Pcd(std::string_view input) {
  std::size_t left_out = 0;
  (void)ParsePcd(input, "scan.pcd", &left_out);
  return StatusOf(ReadScan(FileOf("scan.pcd", input)));
}

/// What assimp makes of a file, through our own front: nodes, units, textures.
Status ByAssimp(std::string_view ending, std::string_view input) {
  const auto folder = FolderOf(input);
  const auto file = folder / ("mesh" + std::string(ending));
  (void)ReadTexturedMesh(file);
  return StatusOf(ReadMesh(file, 1000));
}

Status Obj(std::string_view input) { return ByAssimp(".obj", input); }
Status Gltf(std::string_view input) { return ByAssimp(".gltf", input); }
Status Collada(std::string_view input) { return ByAssimp(".dae", input); }

Status Models(std::string_view input) {
  const auto folder = FolderOf(input);
  (void)CheckModels(folder);
  (void)ReadObjectFromFile(folder);
  return StatusOf(ModelDatabase::Load(folder));
}

constexpr std::array kModelTargets = {Target{"ply", Ply},         Target{"pcd", Pcd},
                                      Target{"obj", Obj},         Target{"gltf", Gltf},
                                      Target{"collada", Collada}, Target{"models", Models}};

}  // namespace

std::span<const Target> ModelTargets() { return kModelTargets; }

}  // namespace plumbline::fuzz
