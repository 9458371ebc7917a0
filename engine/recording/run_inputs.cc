// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_inputs.h"

#include <string_view>

#include "engine/base/log.h"

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

std::string EdgeChoice(const std::string& description) {
  constexpr std::string_view kNetwork = "edge network ";
  if (description.starts_with("dataset")) return "dataset";
  if (!description.starts_with(kNetwork)) return "gradient";
  const std::string file = description.substr(kNetwork.size());
  const std::size_t end = file.find(".onnx");
  return end == std::string::npos ? "gradient" : file.substr(0, end + 5);
}

Result<std::shared_ptr<const Sequence>> OpenSequenceOfRun(const RunChoice& choice,
                                                          const RunHeader& header) {
  const std::filesystem::path path =
      choice.sequence.empty() ? std::filesystem::path(header.sequence_path) : choice.sequence;
  SequenceOptions options{header.poses_path};
  std::error_code ignored;
  if (!options.poses.empty() && !std::filesystem::exists(options.poses, ignored)) {
    log::warn("the trajectory '{}' of the run is not there any more; its sequence's own is shown",
              header.poses_path);
    options.poses.clear();
  }
  return OpenSequence(path, options);
}

Result<std::shared_ptr<const ModelDatabase>> LoadModelsOfRun(const RunChoice& choice,
                                                             const RunHeader& header) {
  const std::filesystem::path models =
      choice.models.empty() ? std::filesystem::path(header.models_path) : choice.models;
  auto database = ModelDatabase::Load(models);
  if (!database.ok())
    return Error{database.error().code,
                 database.error().message + "; --models names another folder"};
  if (Status status = CheckModels(header, **database, choice.run); !status.ok())
    return status.error();
  return database;
}

}  // namespace plumbline
