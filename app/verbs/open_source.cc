// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/open_source.h"

#include "app/verbs/demo_sequence.h"

namespace plumbline {

std::function<MappingProcess::OpenSource(const std::string& path, const std::string& models)>
SourceOpener(const MappingChoice& live, const RunChoice& run) {
  return [live, run](const std::string& path,
                     const std::string& models) -> MappingProcess::OpenSource {
    return [live, run, path,
            models](const WorkContext& work) -> Result<std::unique_ptr<SnapshotSource>> {
      if (std::filesystem::path(path).extension() == ".plb") {
        RunChoice choice = run;
        choice.run = path;
        if (!models.empty()) choice.models = models;
        return OpenRunSource(choice, work);
      }
      MappingChoice choice = live;
      choice.recipe.sequence = path;
      if (!models.empty()) choice.recipe.models = models;
      if (path == kDemoPath) {
        auto demo = BuiltInSequence(kDemoFrames, work);
        if (!demo.ok()) return demo.error();
        choice.recipe.sequence = *demo;
      }
      return OpenMappingSource(choice, work);
    };
  };
}

}  // namespace plumbline
