// SPDX-License-Identifier: Apache-2.0
#pragma once

// The long work of the Annotate workspace as plain functions: they touch nothing but what they are
// given, so that any thread can run them.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/annotation/placement_images.h"
#include "engine/base/progress.h"
#include "engine/geometry/mesh.h"
#include "engine/registration/floor.h"
#include "engine/registration/model_alignment.h"
#include "engine/registration/model_surface.h"
#include "engine/registration/scan_target.h"
#include "engine/snapshot/annotation_snapshot.h"

namespace plumbline {

/// A scan for the eye and for aligning.
struct AnnotationScan {
  std::shared_ptr<const TriangleMesh> full, fine, coarse;
  std::shared_ptr<const ScanTarget> target;
  std::size_t num_left_out = 0;          ///< Points of the file that are not finite.
  std::optional<double> doubted_size_m;  ///< As of TooLargeForMetres.
};

/// Errors: of ReadMesh.
Result<AnnotationScan> ReadAnnotationScan(const std::filesystem::path& file);

/// Writes the scan times `factor` beside its file, or into `fallback` where that cannot be written,
/// under a name that is free. The name. Errors: kIo.
Result<std::filesystem::path> WriteScanInMetres(const TriangleMesh& scan, double factor,
                                                const std::filesystem::path& file,
                                                const std::filesystem::path& fallback);

/// A model where it may go.
struct PlacementTask {
  std::shared_ptr<const ScanTarget> target;
  std::shared_ptr<const TriangleMesh> scan;  ///< For the pictures.
  std::shared_ptr<const ModelSurface> surface;
  std::shared_ptr<const TriangleMesh> mesh;
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
  Eigen::Vector3d up_in_scan{0, 0, 1};
  bool stands = false;  ///< On the level surface below it, which the scan shows or the floor is.
  std::optional<Eigen::Vector4d> floor_in_scan;  ///< As of AlignOptions.
  double view_azimuth_rad = 0;
  double scale = 1;  ///< Of `surface` and `mesh`, of which the next two are the unscaled ones.
  std::shared_ptr<const ModelSurface> unscaled;
  std::shared_ptr<const TriangleMesh> unscaled_mesh;
};

/// Fills in candidates, which stand if the task says so, or where there is nothing to align to the
/// start itself with the reason.
void FindPlacements(const PlacementTask& task, const WorkContext& work, PlacementView& placement);

/// Gives each candidate its agreement with the same few key frames. Where none agrees, the images
/// alone are searched around `start`, and what convinces is added. Where the images clearly prefer
/// a candidate to the first, it becomes the first. `chosen` is told the frames, `changed` when
/// there is something new to see. Without a frame that shows the place nothing changes.
void ComparePlacements(const PlacementQuestion& question, const Eigen::Isometry3d& start,
                       const WorkContext& work,
                       const std::function<void(const PlacementImages&)>& chosen,
                       const std::function<void(const PlacementView&)>& changed,
                       PlacementView& placement);

/// Draws the candidates that have no picture yet.
void AddPictures(const PlacementTask& task, PlacementView& placement);

/// The plane around a seed or by itself, as a proposal. Errors: kDegenerate.
Result<FloorProposal> ProposeFloor(const ScanTarget& target,
                                   const std::optional<Eigen::Vector3d>& seed_in_scan,
                                   const FloorHints& hints, const Eigen::Vector3d& up_now_in_scan);
/// Which points of the scan a floor holds, for looking at it.
void ShowFloorPoints(const ScanTarget& target, FloorProposal& proposal);

}  // namespace plumbline
