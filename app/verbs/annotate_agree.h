// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include <CLI/CLI.hpp>

#include "app/verbs/annotation_inputs.h"
#include "engine/annotation/annotation_export.h"
#include "engine/evaluation/annotator_agreement.h"

namespace plumbline {

/// What a second annotator placed in the same scan.
struct SecondArguments {
  std::string file;            ///< A project, or a ground_truth.json; "": nobody.
  std::string frame = "scan";  ///< Of a ground truth.
  double reach_m = kPairReach_m;
};
void AddSecondOptions(CLI::App& command, SecondArguments& arguments);

/// The frame of an option: "scan", "level" or "world".
PoseFrame FrameOf(const std::string& name);

/// Warns where the second one was made over another scan. Errors: of what is read.
Result<AnnotatorAgreement> CompareWithSecond(const AnnotationProject& project,
                                             const ModelDatabase* models,
                                             const SecondArguments& arguments);

/// How well the project's poses are known by that, for its export; says for how many it is told.
std::map<std::string, PoseDeviation> DeviationsOf(const AnnotationProject& project,
                                                  const AnnotatorAgreement& agreement);

/// `annotate agree`.
Status Agree(const std::string& project, const SecondArguments& arguments,
             const std::string& json_file);

}  // namespace plumbline
