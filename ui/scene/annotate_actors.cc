// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/annotate_actors.h"

#include <algorithm>
#include <cmath>

#include <vtkCellArray.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include "engine/geometry/vertex_clustering.h"
#include "ui/framework/residual_color.h"
#include "ui/framework/theme.h"
#include "ui/scene/scan_actor.h"
#include "ui/scene/vtk_helpers.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr std::size_t kVerticesWhileMoving = 15'000;
constexpr double kEyeHeight_m = 1.5;

/// The 1 .. 99 % box: one stray point must not push the view away.
Eigen::AlignedBox3d RobustBounds(const TriangleMesh& scan, const Isometry3d& level_from_scan) {
  std::vector<double> values[3];
  const std::size_t stride = std::max<std::size_t>(1, scan.vertices.size() / 20000);
  for (std::size_t i = 0; i < scan.vertices.size(); i += stride) {
    const Vector3d point = level_from_scan * scan.vertices[i].cast<double>();
    for (int axis = 0; axis < 3; ++axis) values[axis].push_back(point[axis]);
  }
  Eigen::AlignedBox3d box;
  if (values[0].empty()) return box;
  Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    std::sort(values[axis].begin(), values[axis].end());
    low[axis] = values[axis][values[axis].size() / 100];
    high[axis] = values[axis][values[axis].size() - 1 - values[axis].size() / 100];
  }
  box.extend(low);
  box.extend(high);
  return box;
}

vtkSmartPointer<vtkPolyData> CloudOf(const std::vector<Eigen::Vector3f>& points) {
  vtkNew<vtkPoints> vtk_points;
  vtk_points->SetDataTypeToFloat();
  std::vector<vtkIdType> ids;
  for (const Eigen::Vector3f& p : points) ids.push_back(vtk_points->InsertNextPoint(p.data()));
  vtkNew<vtkCellArray> cells;
  if (!ids.empty()) cells->InsertNextCell(static_cast<vtkIdType>(ids.size()), ids.data());
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(vtk_points);
  data->SetVerts(cells);
  return data;
}

}  // namespace

AnnotateActors::AnnotateActors(vtkRenderer* ground, vtkRenderer* front, bool software_gl)
    : ground_(ground), front_(front), software_gl_(software_gl) {
  grid_ = LineActorOf(SegmentsOf({}), IM_COL32(40, 46, 54, 255), 1);
  grid_major_ = LineActorOf(SegmentsOf({}), IM_COL32(58, 66, 77, 255), 1);
  cameras_ = LineActorOf(SegmentsOf({}), colors::kTrajectory, 1.5);
  inliers_ = LineActorOf(SegmentsOf({}), colors::kGood, 1.25);
  outliers_ = LineActorOf(SegmentsOf({}), colors::kBad, 1.25);
  residuals_ = ActorOf(SegmentsOf({}), IM_COL32_WHITE);
  for (vtkActor* actor : {grid_.Get(), grid_major_.Get(), residuals_.Get()})
    ground_->AddActor(actor);
  for (vtkActor* actor : {cameras_.Get(), inliers_.Get(), outliers_.Get()}) {
    actor->VisibilityOff();
    front_->AddActor(actor);
  }
  residuals_->VisibilityOff();
  vtkMapper::SetResolveCoincidentTopologyToPolygonOffset();  // edges lie on their faces
  residuals_->GetProperty()->SetAmbient(0.45);
  residuals_->GetProperty()->SetDiffuse(0.6);
}

bool AnnotateActors::SetScan(const AnnotationSnapshot& snapshot) {
  const auto wanted =
      software_gl_ && snapshot.scan_coarse != nullptr ? snapshot.scan_coarse : snapshot.scan;
  const bool new_level = level_from_scan_.matrix() != snapshot.level_from_scan.matrix();
  const bool new_scan = wanted != scan_;
  if (!new_scan && !new_level) return false;
  level_from_scan_ = snapshot.level_from_scan;
  for (vtkActor* actor : {scan_fine_.Get(), scan_coarse_.Get()}) {
    if (actor != nullptr) ground_->RemoveActor(actor);
  }
  scan_ = wanted;
  scan_fine_ = scan_coarse_ = nullptr;
  bounds_.setEmpty();
  if (scan_ == nullptr || scan_->empty()) {
    BuildGrid();
    return new_scan;
  }
  bounds_ = RobustBounds(*scan_, level_from_scan_);
  Vector3d eye = bounds_.center();
  eye.z() = std::min(bounds_.min().z() + kEyeHeight_m, bounds_.max().z());
  const Vector3d eye_in_scan = level_from_scan_.inverse() * eye;
  const Vector3d up_in_scan = level_from_scan_.linear().row(2).transpose();
  side_ = scan_->triangles.empty() ? 0 : SideTowards(*scan_, eye_in_scan);
  scan_fine_ = ScanActor(*scan_, up_in_scan, eye_in_scan);
  scan_few_ = ClusterToAbout(*scan_, kVerticesWhileMoving);
  scan_coarse_ = ScanActor(scan_few_, up_in_scan, eye_in_scan);
  scan_look_.reset();
  for (vtkActor* actor : {scan_fine_.Get(), scan_coarse_.Get()}) {
    SetPose(*actor, level_from_scan_);
    ground_->AddActor(actor);
  }
  SetCoarse(coarse_);
  BuildGrid();
  return true;
}

void AnnotateActors::SetScanLook(const ScanLook& look) {
  if (scan_fine_ == nullptr || look == scan_look_) return;
  const ScanColoring coloring =
      look.coloring.value_or(HasColors(*scan_) ? ScanColoring::kOwn : ScanColoring::kHeight);
  const Vector3d up_in_scan = level_from_scan_.linear().row(2).transpose();
  if (!scan_look_ || scan_look_->coloring != look.coloring) {
    ColorScan(*scan_fine_, ScanColors(*scan_, up_in_scan, coloring));
    ColorScan(*scan_coarse_, ScanColors(scan_few_, up_in_scan, coloring));
  }
  for (vtkActor* actor : {scan_fine_.Get(), scan_coarse_.Get()})
    actor->GetProperty()->SetPointSize(look.point_px);
  scan_look_ = look;
}

void AnnotateActors::BuildGrid() {
  std::vector<Vector3d> minor, major;
  const Eigen::AlignedBox3d box =
      bounds_.isEmpty() ? Eigen::AlignedBox3d(Vector3d(-3, -3, 0), Vector3d(3, 3, 0)) : bounds_;
  const auto low = [&](int axis) {
    return static_cast<int>(std::floor(box.min()[axis] / kGridStep_m)) - 1;
  };
  const auto high = [&](int axis) {
    return static_cast<int>(std::ceil(box.max()[axis] / kGridStep_m)) + 1;
  };
  const double z = -0.004;  // a floor at 0 must not flicker
  for (int i = low(0); i <= high(0); ++i) {
    auto& lines = i % 2 == 0 ? major : minor;
    lines.emplace_back(i * kGridStep_m, low(1) * kGridStep_m, z);
    lines.emplace_back(i * kGridStep_m, high(1) * kGridStep_m, z);
  }
  for (int i = low(1); i <= high(1); ++i) {
    auto& lines = i % 2 == 0 ? major : minor;
    lines.emplace_back(low(0) * kGridStep_m, i * kGridStep_m, z);
    lines.emplace_back(high(0) * kGridStep_m, i * kGridStep_m, z);
  }
  SetData(*grid_, SegmentsOf(minor));
  SetData(*grid_major_, SegmentsOf(major));
}

void AnnotateActors::SetCoarse(bool coarse) {
  coarse_ = coarse;
  if (scan_fine_ == nullptr) return;
  scan_fine_->SetVisibility(scan_shown_ && !coarse);
  scan_coarse_->SetVisibility(scan_shown_ && coarse);
}

const AnnotateActors::Shape& AnnotateActors::ShapeOf(const AnnotationSnapshot& snapshot,
                                                     int model) {
  Shape& shape = shapes_[model];
  if (shape.surface == nullptr) {
    shape.surface = SurfaceOf(*snapshot.Model(model)->mesh);
    shape.edges = SharpEdgesOf(shape.surface);
  }
  return shape;
}

AnnotateActors::Posed& AnnotateActors::Next() {
  if (used_ == posed_.size()) {
    Posed posed{ActorOf(SegmentsOf({}), IM_COL32_WHITE),
                LineActorOf(SegmentsOf({}), IM_COL32_WHITE, 1), ""};
    ShowOwnColors(*posed.surface, false);
    posed.surface->GetProperty()->SetAmbient(0.25);
    posed.surface->GetProperty()->SetDiffuse(0.75);
    ground_->AddActor(posed.surface);
    ground_->AddActor(posed.edges);
    posed_.push_back(std::move(posed));
  }
  return posed_[used_++];
}

void AnnotateActors::Show(const AnnotateContent& content, int model,
                          const Isometry3d& scan_from_object, ImU32 color, double opacity,
                          bool outlined, const std::string& id, double scale) {
  const Shape& shape = ShapeOf(*content.snapshot, model);
  const Isometry3d pose = level_from_scan_ * scan_from_object;
  Posed& posed = Next();
  posed.id = id;
  SetData(*posed.surface, shape.surface);
  SetData(*posed.edges, shape.edges);
  SetPose(*posed.surface, pose, scale);
  SetPose(*posed.edges, pose, scale);
  SetColor(*posed.surface, color);
  SetColor(*posed.edges,
           outlined ? Mixed(color, IM_COL32_WHITE, 0.8) : Mixed(color, IM_COL32_BLACK, 0.35));
  posed.surface->GetProperty()->SetOpacity(opacity);
  posed.edges->GetProperty()->SetLineWidth(outlined ? 1.3f : 1.0f);
  posed.surface->VisibilityOn();
  posed.edges->VisibilityOn();
}

void AnnotateActors::Update(const AnnotateContent& content) {
  const AnnotationSnapshot& snapshot = *content.snapshot;
  if (snapshot.models != models_) {
    if (models_ == nullptr || models_->size() != snapshot.models->size()) shapes_.clear();
    models_ = snapshot.models;
  }
  scan_shown_ = content.scan;
  SetCoarse(coarse_);
  grid_->SetVisibility(content.grid);
  grid_major_->SetVisibility(content.grid);
  for (Posed& posed : posed_) {
    posed.surface->VisibilityOff();
    posed.edges->VisibilityOff();
    posed.id.clear();
  }
  used_ = 0;
  ShowInstances(content);
  ShowProposals(content);
  std::vector<Vector3d> path;
  for (const Vector3d& camera : snapshot.cameras_in_scan) path.push_back(level_from_scan_ * camera);
  SetData(*cameras_, PolylineOf(path));
  cameras_->SetVisibility(content.cameras && path.size() > 1);
}

void AnnotateActors::ShowInstances(const AnnotateContent& content) {
  const AnnotationSnapshot& snapshot = *content.snapshot;
  if (!content.models) return;
  int number = 0;
  for (const AnnotatedInstance& instance : snapshot.instances) {
    ++number;
    if (instance.hidden || snapshot.ModelOf(instance) == nullptr) continue;
    const bool refined = snapshot.refinement && snapshot.refinement->instance == instance.id;
    const bool again = snapshot.placement && snapshot.placement->instance == instance.id &&
                       !snapshot.placement->candidates.empty();
    if (refined || again) continue;
    const Isometry3d* pending = content.pending ? content.pending->Find(instance.id) : nullptr;
    const auto& also = content.also_selected;
    const bool selected = snapshot.selected == instance.id ||
                          std::find(also.begin(), also.end(), instance.id) != also.end();
    Show(content, snapshot.ModelIndex(instance),
         pending != nullptr ? *pending : instance.scan_from_object,
         SeriesColor(static_cast<std::size_t>(number - 1)), 1.0, selected, instance.id,
         instance.scale);
  }
}

void AnnotateActors::ShowProposals(const AnnotateContent& content) {
  const AnnotationSnapshot& snapshot = *content.snapshot;
  const auto& floor = snapshot.floor;
  const auto& crop = snapshot.crop;
  const bool cut = crop && crop->points != nullptr;
  const auto* shown = floor          ? floor->inliers.get()
                      : cut          ? crop->points.get()
                      : snapshot.box ? snapshot.box->points.get()
                                     : nullptr;
  ShowPoints(inliers_, shown, level_from_scan_);
  ShowPoints(outliers_, floor ? floor->outliers.get() : nullptr, level_from_scan_);
  if (const auto& placement = snapshot.placement; placement && !placement->candidates.empty()) {
    const auto chosen = static_cast<std::size_t>(
        std::clamp(content.candidate, 0, static_cast<int>(placement->candidates.size()) - 1));
    Show(content, placement->model, placement->candidates[chosen].scan_from_object, colors::kAccent,
         1.0, true, "", placement->scale);
  }
  if (content.ghost) {
    Show(content, content.ghost->model, content.ghost->scan_from_object, colors::kAccent, 0.45,
         true, "");
  }
  ShowOther(content);
  residuals_->VisibilityOff();
  if (snapshot.refinement) ShowResiduals(snapshot, *snapshot.refinement);
}

/// Where the other annotator has the object of the row that is looked at.
void AnnotateActors::ShowOther(const AnnotateContent& content) {
  const auto& agreement = content.snapshot->agreement;
  if (!agreement || content.agreed_row < 0 ||
      content.agreed_row >= static_cast<int>(agreement->rows.size()))
    return;
  const AgreedRowView& row = agreement->rows[static_cast<std::size_t>(content.agreed_row)];
  AnnotatedInstance other;
  other.model = row.second_model;
  const int model = content.snapshot->ModelIndex(other);
  if (row.second.empty() || model < 0) return;
  Show(content, model, row.second_from, IM_COL32_WHITE, 1.0, true, "", row.second_scale);
  Posed& shown = posed_[used_ - 1];
  shown.surface->VisibilityOff();
  SetColor(*shown.edges, content.light ? IM_COL32_BLACK : IM_COL32_WHITE);
  shown.edges->GetProperty()->SetLineWidth(2.0f);
}

void AnnotateActors::ShowResiduals(const AnnotationSnapshot& snapshot,
                                   const RefinementView& refinement) {
  const AnnotatedInstance* instance = snapshot.Find(refinement.instance);
  const AnnotationModel* model = instance != nullptr ? snapshot.ModelOf(*instance) : nullptr;
  if (model == nullptr) return;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToFloat();
  for (const Eigen::Vector3f& v : model->mesh->vertices) points->InsertNextPoint(v.data());
  vtkNew<vtkCellArray> cells;
  for (const Eigen::Vector3i& t : model->mesh->triangles) {
    const vtkIdType ids[3] = {t[0], t[1], t[2]};
    cells->InsertNextCell(3, ids);
  }
  vtkNew<vtkUnsignedCharArray> rgb;
  rgb->SetNumberOfComponents(3);
  for (std::size_t i = 0; i < model->mesh->vertices.size(); ++i) {
    const bool known = refinement.residuals_m != nullptr && i < refinement.residuals_m->size();
    const cv::Vec3b bgr = BgrOf(ResidualColor(known ? (*refinement.residuals_m)[i] : -1.0f));
    rgb->InsertNextTuple3(bgr[2], bgr[1], bgr[0]);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  data->GetPointData()->SetScalars(rgb);
  SetData(*residuals_, data);
  SetPose(*residuals_, level_from_scan_ * refinement.scan_from_object, refinement.scale);
  residuals_->VisibilityOn();
}

void AnnotateActors::ShowPoints(vtkActor* actor, const std::vector<Eigen::Vector3f>* points,
                                const Isometry3d& level_from_scan) {
  actor->SetVisibility(points != nullptr && !points->empty());
  if (points == nullptr || points->empty()) return;
  SetData(*actor, CloudOf(*points));
  SetPose(*actor, level_from_scan);
}

std::vector<std::pair<vtkActor*, std::string>> AnnotateActors::pickable() const {
  std::vector<std::pair<vtkActor*, std::string>> actors;
  for (std::size_t i = 0; i < used_; ++i) {
    if (!posed_[i].id.empty()) actors.emplace_back(posed_[i].surface.Get(), posed_[i].id);
  }
  return actors;
}

}  // namespace plumbline
