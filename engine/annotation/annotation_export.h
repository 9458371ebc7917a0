// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "engine/annotation/pose_exchange.h"
#include "engine/base/progress.h"
#include "engine/models/gltf_file.h"

namespace plumbline {

/// How well a pose is known: one standard deviation, as of GroundTruthInstance.
struct PoseDeviation {
  std::optional<double> position_std_m, azimuth_std_rad;
};

/// What to write, and where.
struct ExportRequest {
  std::string format;         ///< Of kExportFormats (engine/snapshot/export_formats.h).
  std::filesystem::path out;  ///< A file or a folder, as the format has it.
  PoseFrame frame = PoseFrame::kScan;
  std::map<std::string, PoseDeviation> deviations = {};  ///< By id; of ground_truth alone.
  GltfUp up = GltfUp::kY;                                ///< Of gltf alone.
};

/// The same annotations in another frame of the scan; nothing stays behind.
AnnotationDocument InFrame(const AnnotationDocument& document,
                           const Eigen::Isometry3d& target_from_scan);

/// Writes the document in any format. `scan_file`: what VISMA's and Scan2CAD's folders hold of the
/// scan; empty: nothing. Where the scan's mesh goes along, it goes into the same frame. Errors:
/// kInvalidInput (no such format, no objects, a sequence or models that are missing, a frame that
/// the format does not know), kIo, kCancelled.
Status ExportAnnotation(const AnnotationDocument& document, const ExchangeInputs& inputs,
                        const std::filesystem::path& scan_file, const ExportRequest& request,
                        const WorkContext& work);

}  // namespace plumbline
