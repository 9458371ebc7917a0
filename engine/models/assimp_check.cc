// SPDX-License-Identifier: Apache-2.0
#include "engine/models/assimp_check.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <vector>

#include "engine/base/files.h"
#include "engine/models/collada_check.h"

namespace plumbline {
namespace {

std::string Lowered(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return text;
}

Error Corrupt(const std::filesystem::path& file, const std::string& what) {
  return {ErrorCode::kCorrupt, "'" + file.string() + "' " + what};
}

/// Whether a file of materials (.mtl) names a texture before any material: a null pointer.
bool HasTextureOfNoMaterial(const std::string& materials) {
  std::istringstream lines(materials);
  for (std::string line, word; std::getline(lines, line);) {
    word.clear();
    std::istringstream(line) >> word;
    word = Lowered(word);
    if (word == "newmtl") return false;
    for (const char* texture : {"map_", "bump", "norm", "disp", "refl"})
      if (word.starts_with(texture)) return true;
  }
  return false;
}

/// The files of materials that an .obj names, and the one that assimp looks for beside it.
std::vector<std::filesystem::path> MaterialsOf(const std::filesystem::path& obj) {
  std::vector<std::filesystem::path> files = {std::filesystem::path(obj).replace_extension(".mtl")};
  const Result<std::string> text = ReadFile(obj);
  if (!text.ok()) return files;
  std::istringstream lines(*text);
  for (std::string line, word; std::getline(lines, line);) {
    std::istringstream words(line);
    if (!(words >> word) || Lowered(word) != "mtllib") continue;
    std::getline(words >> std::ws, word);
    files.push_back(obj.parent_path() / word.substr(0, word.find_last_not_of(" \r") + 1));
  }
  return files;
}

Status CheckObj(const std::filesystem::path& file) {
  for (const std::filesystem::path& materials : MaterialsOf(file)) {
    const Result<std::string> text = ReadFile(materials);
    if (text.ok() && HasTextureOfNoMaterial(*text))
      return Corrupt(materials, "names a texture before any material (newmtl)");
  }
  return {};
}

}  // namespace

Status CheckBeforeAssimp(const std::filesystem::path& file, const std::string& ending) {
  if (ending == ".obj") return CheckObj(file);
  if (ending == ".dae") {
    const Result<std::string> text = ReadFile(file);
    if (!text.ok()) return text.error();
    const std::string problem = ColladaProblem(*text);
    if (!problem.empty()) return Corrupt(file, "is damaged: " + problem);
  }
  return {};
}

}  // namespace plumbline
