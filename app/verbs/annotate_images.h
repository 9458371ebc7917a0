// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/verbs/annotation_inputs.h"
#include "engine/annotation/joint_refinement.h"

namespace plumbline {

/// Which images of the project's sequence an object is compared with.
struct ImageArguments {
  int frames = 12;
  std::string among;  ///< The frames that they may be of, as A:B[:S]; empty: all.
  std::string edges;
};
void AddImageOptions(CLI::App& command, ImageArguments& arguments, const char* least_frames);

struct RefineArguments {
  std::vector<std::string> instances;  ///< All that are not locked where there are none.
  std::string by = "both";             ///< or "scan", "images"
  int dof = 4;
  bool all_azimuths = false;  ///< First, the images say which way round it stands.
  double camera_std_cm = 100 * kUsualCameraStd_m;
  ImageRefinementOptions options;
};
void AddRefineOptions(CLI::App& command, RefineArguments& arguments);

/// Prints, unless `quiet`, and returns for each instance how well its outline lies on the edges of
/// the images. The project must have models and a sequence.
Result<nlohmann::json> CheckByImages(const AnnotationProject& project, const OpenedInputs& inputs,
                                     const ImageArguments& arguments, bool quiet);

/// `annotate refine`.
Status RefineInstances(const std::string& project, const ImageArguments& images,
                       const RefineArguments& arguments, const std::string& json_file);

}  // namespace plumbline
