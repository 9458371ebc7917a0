// SPDX-License-Identifier: Apache-2.0
#include "app/info/path_info.h"

#include "app/info/info_text.h"

namespace plumbline {
namespace {

constexpr KnownPath kKinds[] = {
    {"sequence", "a sequence", ProbeSequence, DescribeSequence},
    {"run", "a run (.plb)", ProbeRun, DescribeRun},
    {"models", "a folder of models (models.json)", ProbeModels, DescribeModels},
    {"project", "an annotation project (.json)", ProbeProject, DescribeProject},
    {"network", "a network (.onnx)", ProbeNetwork, DescribeNetwork},
    {"mesh", "a mesh or scan (.ply, .obj, ..)", ProbeMesh, DescribeMesh},
    {"trajectory", "a trajectory (TUM)", ProbeTrajectory, DescribeTrajectory},
};

}  // namespace

std::span<const KnownPath> PathKinds() { return kKinds; }

Result<PathInfo> DescribePath(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    return Error{ErrorCode::kNotFound, "there is no '" + path.string() + "'"};
  // Whoever looked into a pipe would wait for somebody to write.
  if (!std::filesystem::is_regular_file(path, ignored) &&
      !std::filesystem::is_directory(path, ignored)) {
    return Error{
        ErrorCode::kInvalidInput,
        "'" + path.string() + "' is a device, pipe or socket; a file or a folder is needed"};
  }
  const KnownPath* best = nullptr;
  Likeness surest = Likeness::kNone;
  std::string expected;
  for (const KnownPath& kind : kKinds) {
    expected += (expected.empty() ? "" : ", ") + std::string(kind.expects);
    const Likeness likeness = kind.probe(path);
    if (likeness <= surest) continue;
    surest = likeness;
    best = &kind;
  }
  if (best == nullptr) {
    return Error{ErrorCode::kUnsupported,
                 "'" + path.string() + "' is nothing that Plumbline knows: " + expected};
  }
  Result<PathInfo> info = best->describe(path);
  if (!info.ok()) return info.error();
  const std::uintmax_t bytes = BytesOnDisk(path);
  info->lines.push_back({"On disk", BytesText(bytes)});
  info->json["kind"] = best->name;
  info->json["path"] = path.string();
  info->json["title"] = info->title;
  info->json["bytes"] = bytes;
  info->json["odd"] = info->odd;
  return info;
}

}  // namespace plumbline
