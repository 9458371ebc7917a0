// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the Annotate workspace brings a sequence into the frame of the scan, as plain functions that
// any thread can run.

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/annotation/annotation_document.h"
#include "engine/base/progress.h"
#include "engine/dataset/sequence.h"
#include "engine/registration/sequence_alignment.h"
#include "engine/snapshot/annotation_snapshot.h"

namespace plumbline {

/// Down in both. Errors: kInvalidInput where the sequence does not know gravity.
Result<GravityPair> GravityOf(const AnnotationDocument& document, const Sequence& sequence);

/// Errors: kInvalidInput (gravity, a frame without a pose), and those of AlignByPairs.
Result<SequenceAlignment> RegisterByPicks(const AnnotationDocument& document,
                                          const Sequence& sequence,
                                          const std::vector<FramePick>& picks,
                                          const std::vector<PickedPair>& more = {});
/// @param points  A point cloud in the sequence's world, as of ReadMesh.
/// Errors: of ReadMesh and AlignByPoints.
Result<SequenceAlignment> RegisterByPoints(const AnnotationDocument& document,
                                           const Sequence& sequence, const ScanTarget& scan,
                                           const std::filesystem::path& points,
                                           const WorkContext& work);
/// The objects of a run and those of the document; kinds are categories. `names`: of the mapped
/// ones, as the residuals. Errors: of ReadEstimates and AlignByObjects.
Result<SequenceAlignment> RegisterByObjects(const AnnotationDocument& document,
                                            const Sequence& sequence,
                                            const std::filesystem::path& run,
                                            std::vector<std::string>& names);

/// Where a frame's camera sees a point of the scan; nothing behind it or without a pose.
std::optional<Eigen::Vector2d> SeenAt(const Sequence& sequence, int frame,
                                      const std::optional<Eigen::Isometry3d>& scan_from_world,
                                      const Eigen::Vector3d& in_scan);

}  // namespace plumbline
