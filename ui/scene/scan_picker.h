// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStaticCellLocator.h>
#include <Eigen/Core>

#include "engine/geometry/mesh.h"

namespace plumbline {

/// Finds the point of a scan on a line of sight: of a surface where the line meets it (not on the
/// side that is not drawn), of a cloud the nearest point of those within a narrow cone.
class ScanPicker {
 public:
  /// @param side  Of the triangles that is drawn: +1 front, -1 back, 0 both.
  ScanPicker(std::shared_ptr<const TriangleMesh> scan, int side);

  /// @param cone_rad  Half opening within which a cloud's point counts.
  std::optional<Eigen::Vector3d> Pick(const Eigen::Vector3d& eye_in_scan,
                                      const Eigen::Vector3d& direction_in_scan,
                                      double cone_rad) const;

 private:
  std::optional<Eigen::Vector3d> PickSurface(const Eigen::Vector3d& eye,
                                             const Eigen::Vector3d& direction) const;
  std::optional<Eigen::Vector3d> PickCloud(const Eigen::Vector3d& eye,
                                           const Eigen::Vector3d& direction, double cone_rad) const;

  std::shared_ptr<const TriangleMesh> scan_;
  int side_;
  vtkNew<vtkPolyData> data_;
  vtkNew<vtkStaticCellLocator> locator_;
};

}  // namespace plumbline
