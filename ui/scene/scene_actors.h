// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include <vtkActor.h>
#include <vtkNew.h>
#include <vtkPlaneCollection.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTexture.h>

#include "ui/framework/scene_surface.h"

namespace plumbline {

struct ObjectReport;

/// The actors of the map: built with the sequence, moved with every snapshot.
class SceneActors {
 public:
  /// How far behind everything the image is when one looks through the camera.
  static constexpr double kBackdrop_m = 60;

  /// `ground` is drawn first and holds scan and grid: estimates are never hidden by the scan that
  /// they explain.
  SceneActors(vtkRenderer* ground, vtkRenderer* renderer, bool software_gl);

  void SetSequence(const SequenceView& sequence);
  /// `content.sequence` is not null.
  void SetSnapshot(const SceneContent& content);
  /// Coarse: few triangles of the scan.
  void SetCoarse(bool coarse);
  /// Actors that answer to picking, with their objects.
  std::vector<std::pair<vtkActor*, ObjectId>> pickable() const;
  /// Box of truth, trajectory and scan.
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  /// Box of truth and trajectory where there are any: what the first view shows.
  const Eigen::AlignedBox3d& focus_bounds() const { return focus_bounds_; }
  vtkActor* scan() const { return scan_fine_; }
  /// Azimuth about up from which the cameras look at the middle of the bounds, on the whole.
  double ViewAzimuth(const SequenceView& sequence) const;
  double grid_step_m() const { return grid_step_m_; }

 private:
  struct ModelData {
    vtkSmartPointer<vtkPolyData> surface, edges;
  };
  struct ObjectActors {
    vtkSmartPointer<vtkActor> surface, edges;
  };
  struct CameraActors {
    vtkSmartPointer<vtkActor> lines, picture;
    vtkSmartPointer<vtkTexture> texture;
  };

  void AddModels(const SequenceView& sequence);
  void AddTruth(const SequenceView& sequence);
  void AddSmoothed(const SequenceView& sequence);
  void AddScan(const SequenceView& sequence);
  void AddTrajectory(const SequenceView& sequence);
  void AddGrid(const SequenceView& sequence);
  void UpdateObjects(const SceneContent& content);
  void UpdateCamera(const SceneContent& content);
  void UpdateTrajectory(const SceneContent& content);
  void UpdateParticles(const SceneContent& content);
  void Clip(const SceneContent& content);
  ObjectActors& ActorsOf(const ObjectReport& object);

  vtkRenderer* ground_;
  vtkRenderer* renderer_;
  bool software_gl_;
  bool coarse_ = false;
  Eigen::AlignedBox3d bounds_, focus_bounds_;
  double grid_step_m_ = 0.5;
  std::vector<ModelData> models_;
  std::vector<vtkSmartPointer<vtkActor>> truth_, truth_solid_, smoothed_;
  vtkSmartPointer<vtkActor> scan_fine_, scan_coarse_;
  vtkSmartPointer<vtkActor> trajectory_, walked_;
  vtkSmartPointer<vtkActor> grid_, grid_major_;
  vtkSmartPointer<vtkActor> particles_, selected_particle_;
  CameraActors camera_;
  std::map<ObjectId, ObjectActors> objects_;
  bool scan_shown_ = true;
  vtkNew<vtkPlaneCollection> clip_planes_;  ///< The sides of the clip box.
};

}  // namespace plumbline
