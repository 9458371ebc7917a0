// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "engine/base/result.h"
#include "engine/pipeline/run_recipe.h"

namespace plumbline {

/// What commands that map a sequence share.
struct PipelineArguments {
  RunRecipe recipe;  ///< Complete after Finish, but for the sequence.
  std::string frames, options_file, poses = "dataset", detector, edges, scorer = "viewpoint",
                                    preset = "default";
  std::vector<std::string> settings, pose_settings;
  std::string live;  ///< "true" for --live alone; empty: without it.

  /// Declares --models, --frames, --seed, --detector, --edges, --poses, --set-poses, --preset,
  /// --options and --set.
  void AddTo(CLI::App& verb);
  /// Declares --live.
  void AddLiveTo(CLI::App& verb);
  /// Reads the range and the options into `recipe`. Errors: kInvalidInput, kNotFound.
  Status Finish();
};

}  // namespace plumbline
