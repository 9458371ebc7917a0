// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/annotation/staged_export.h"
#include "engine/evaluation/map_evaluation.h"
#include "engine/recording/run_inputs.h"

namespace plumbline {

/// Names of the formats of posed objects, of annotations or of a run's map.
enum class ExportedFrom { kAnnotation, kRun };
std::vector<std::string> RoomFormats(ExportedFrom from);
/// What they are, a sentence for each.
std::string RoomFormatsHelp(ExportedFrom from);

/// `y` or `z`.
GltfUp UpFrom(const std::string& name);

/// Writes an export into its place and says what was there: "bop: 11 instances", then
/// `remark`, what differs, and where it is kept.
Status WriteAndSay(const AnnotationDocument& document, const ExchangeInputs& inputs,
                   const std::filesystem::path& scan_file, const ExportRequest& request,
                   const std::string& remark);

/// The objects of a run's map in one of these formats. @param frames  A:B:S; "" all of the run.
Status ExportRoomOfRun(const RunChoice& choice, const RunHeader& header,
                       const std::vector<EstimatedObject>& objects, const ExportRequest& request,
                       const std::string& frames);

/// The frames of the sequence that are in the range; none without a sequence.
std::vector<int> ChosenFrames(const Sequence* sequence, const FrameRange& range);

}  // namespace plumbline
