// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/open_source.h"

#include <atomic>
#include <filesystem>
#include <memory>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/verbs/demo_sequence.h"
#include "engine/base/files.h"
#include "engine/vision/network_guess.h"

namespace plumbline {
namespace {

/// RUN-2.plb beside RUN.plb, or the next number that is free.
std::filesystem::path FreeBeside(const std::filesystem::path& run) {
  std::error_code ignored;
  for (int i = 2;; ++i) {
    auto name = run.parent_path() /
                (run.stem().string() + "-" + std::to_string(i) + run.extension().string());
    if (!std::filesystem::exists(name, ignored)) return name;
  }
}

/// Writes the sidecar that a network looks like, where it has none.
Status KeepGuess(const std::filesystem::path& network) {
  std::error_code ignored;
  const auto sidecar = std::filesystem::path(network).replace_extension(".json");
  if (network.extension() != ".onnx" || std::filesystem::exists(sidecar, ignored)) return {};
  const Result<NetworkGuess> guess = GuessSidecar(network);
  if (!guess.ok()) return guess.error();
  return WriteJson(sidecar, SidecarToJson(guess->sidecar));
}

/// Of what was chosen in the window.
Status Use(const OpenWith& with, RunRecipe& recipe) {
  if (!with.models.empty()) recipe.models = with.models;
  if (with.find_poses) recipe.poses = {PoseSource::kVio, {}};
  if (with.options) recipe.options = *with.options;
  if (!with.edges.empty()) recipe.edges = ParseEdges(with.edges);
  if (!with.detector.empty()) recipe.detector = ParseDetector(with.detector);
  if (Status status = KeepGuess(with.edges); !status.ok()) return status;
  return KeepGuess(with.detector);
}

}  // namespace

decltype(InspectOptions::opener) SourceOpener(const MappingChoice& live, const RunChoice& run) {
  const auto recorded = std::make_shared<std::atomic<bool>>(false);
  return [live, run, recorded](const std::string& path,
                               const OpenWith& with) -> MappingProcess::OpenSource {
    return [live, run, recorded, path,
            with](const WorkContext& work) -> Result<std::unique_ptr<SnapshotSource>> {
      if (std::filesystem::path(path).extension() == ".plb") {
        RunChoice choice = run;
        choice.run = path;
        if (!with.models.empty()) choice.models = with.models;
        return OpenRunSource(choice, work);
      }
      MappingChoice choice = live;
      choice.recipe.sequence = path;
      if (Status status = Use(with, choice.recipe); !status.ok()) return status.error();
      if (path == kDemoPath) {
        auto demo = BuiltInSequence(kDemoFrames, work);
        if (!demo.ok()) return demo.error();
        choice.recipe.sequence = *demo;
      }
      if (*recorded && !choice.out.empty()) choice.out = FreeBeside(choice.out);
      auto source = OpenMappingSource(choice, work);
      if (source.ok()) *recorded = true;
      return source;
    };
  };
}

}  // namespace plumbline
