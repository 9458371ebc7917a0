// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_inputs.h"

#include "engine/base/log.h"
#include "engine/pipeline/own_pose_sequence.h"
#include "engine/recording/run_file.h"

namespace plumbline {
namespace {

/// The labels of a run count its models; with other models they would mean other shapes.
Status CheckModels(const RunHeader& header, const ModelDatabase& database,
                   const std::filesystem::path& run) {
  bool same = header.models.size() == database.models().size();
  for (std::size_t i = 0; same && i < header.models.size(); ++i)
    same = header.models[i].name == database.models()[i].name;
  if (same) return {};
  return Error{ErrorCode::kInvalidInput,
               "the models in '" + database.folder().string() + "' are not those that '" +
                   run.string() + "' was made with; name the right folder with --models"};
}

}  // namespace

RunRecipe RecipeOf(const RunChoice& choice, const RunHeader& header) {
  RunRecipe recipe = header.recipe;
  recipe.live_speed.reset();
  if (!choice.sequence.empty()) recipe.sequence = choice.sequence;
  if (!choice.models.empty()) recipe.models = choice.models;
  return recipe;
}

Result<std::shared_ptr<const Sequence>> OpenSequenceOfRun(const RunChoice& choice,
                                                          const RunHeader& header) {
  const RunRecipe recipe = RecipeOf(choice, header);
  SequenceOptions options{recipe.poses.file};
  std::error_code ignored;
  if (!options.poses.empty() && !std::filesystem::exists(options.poses, ignored)) {
    log::warn("the trajectory '{}' of the run is not there any more; its sequence's own is shown",
              options.poses.string());
    options.poses.clear();
  }
  auto sequence = OpenSequence(recipe.sequence, options);
  if (!sequence.ok() || recipe.poses.source != PoseSource::kVio) return sequence;
  const auto reader = RunReader::Open(choice.run);
  if (!reader.ok()) return reader.error();
  auto own_poses = (*reader)->ReadOwnPoses();
  if (!own_poses.ok()) return own_poses.error();
  if (*own_poses == nullptr || (*sequence)->num_frames() < header.end_frame) return sequence;
  return WithOwnPoses(*sequence, *own_poses);
}

Result<std::shared_ptr<const ModelDatabase>> LoadModelsOfRun(const RunChoice& choice,
                                                             const RunHeader& header) {
  auto database = ModelDatabase::Load(RecipeOf(choice, header).models);
  if (!database.ok())
    return Error{database.error().code,
                 database.error().message + "; --models names another folder"};
  if (Status status = CheckModels(header, **database, choice.run); !status.ok())
    return status.error();
  return database;
}

}  // namespace plumbline
