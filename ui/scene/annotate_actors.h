// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <vtkActor.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include "ui/framework/annotate_view.h"

namespace plumbline {

/// The actors of the Annotate workspace, all in the level frame. Scan and models hide one another
/// as they stand; outlines and what is proposed lie over them.
class AnnotateActors {
 public:
  static constexpr double kGridStep_m = 0.5;

  AnnotateActors(vtkRenderer* ground, vtkRenderer* front, bool software_gl);

  /// Takes the scan and where level is; true if either changed.
  bool SetScan(const AnnotationSnapshot& snapshot);
  /// Colours and points of the scan.
  void SetScanLook(const ScanLook& look);
  void Update(const AnnotateContent& content);
  void SetCoarse(bool coarse);

  std::vector<std::pair<vtkActor*, std::string>> pickable() const;
  /// Of the scan without stray points, level.
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  double size_m() const { return bounds_.isEmpty() ? 0 : bounds_.diagonal().norm(); }
  /// What is drawn at rest; null without a scan.
  std::shared_ptr<const TriangleMesh> shown_scan() const { return scan_; }
  /// Of its triangles: +1 only fronts are drawn, -1 only backs, 0 both.
  int scan_side() const { return side_; }

 private:
  struct Shape {
    vtkSmartPointer<vtkPolyData> surface, edges;
  };
  struct Posed {
    vtkSmartPointer<vtkActor> surface, edges;
    std::string id;  ///< "" if it cannot be picked.
  };

  void BuildGrid();
  const Shape& ShapeOf(const AnnotationSnapshot& snapshot, int model);
  Posed& Next();
  void Show(const AnnotateContent& content, int model, const Eigen::Isometry3d& scan_from_object,
            ImU32 color, double opacity, bool outlined, const std::string& id, double scale = 1);
  void ShowInstances(const AnnotateContent& content);
  void ShowProposals(const AnnotateContent& content);
  void ShowOther(const AnnotateContent& content);
  void ShowResiduals(const AnnotationSnapshot& snapshot, const RefinementView& refinement);
  void ShowPoints(vtkActor* actor, const std::vector<Eigen::Vector3f>* points,
                  const Eigen::Isometry3d& level_from_scan);

  vtkRenderer* ground_;
  vtkRenderer* front_;
  bool software_gl_;
  bool coarse_ = false, scan_shown_ = true;
  std::shared_ptr<const TriangleMesh> scan_;
  TriangleMesh scan_few_;              ///< The same while the view moves.
  std::optional<ScanLook> scan_look_;  ///< Of the actors; nothing: they are new.
  Eigen::Isometry3d level_from_scan_ = Eigen::Isometry3d::Identity();
  int side_ = 0;
  Eigen::AlignedBox3d bounds_;
  vtkSmartPointer<vtkActor> scan_fine_, scan_coarse_, grid_, grid_major_, cameras_, inliers_,
      outliers_, residuals_;
  std::shared_ptr<const std::vector<AnnotationModel>> models_;
  std::map<int, Shape> shapes_;
  std::vector<Posed> posed_;
  std::size_t used_ = 0;
};

}  // namespace plumbline
