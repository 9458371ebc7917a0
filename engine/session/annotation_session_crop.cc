// SPDX-License-Identifier: Apache-2.0
// The part of the session that cuts objects out of the scan.
#include <utility>

#include "engine/annotation/box_around.h"
#include "engine/annotation/crop_cut.h"
#include "engine/annotation/crop_models.h"
#include "engine/geometry/gravity.h"
#include "engine/session/annotation_session.h"

namespace plumbline {
namespace {

/// What there is to see of a crop that can be taken.
void Show(const PreparedCrop& prepared, const TriangleMesh& scan, const Eigen::Vector3d& up,
          const std::optional<Eigen::Vector4d>& floor, CropView& view) {
  auto points = std::make_shared<std::vector<Eigen::Vector3f>>();
  for (const Edit& edit : prepared.edit.edits) {
    const auto* add = std::get_if<AddCrop>(&edit);
    if (add == nullptr) continue;
    view.id = add->crop.id;
    if (const auto cut = CutOut(scan, add->crop)) *points = cut->vertices;
    const auto& support = add->crop.support_in_scan;
    if (add->crop.without_support && support && floor) {
      view.support_height_m = (*floor)[3] - (*support)[3];
    }
  }
  const Eigen::Matrix3d level = UprightFrame(-up).upright_rotation();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& point : *points) {
    box.extend(Eigen::Vector3d(level.transpose() * point.cast<double>()));
  }
  if (!box.isEmpty()) view.size_m = box.sizes();
  if (prepared.model) {
    view.num_faces = static_cast<int>(prepared.model->built.model.mesh.triangles.size());
    view.size_m = prepared.model->built.model.bounds.sizes().cast<double>();
  }
  view.points = std::move(points);
}

CropBox RegionOf(const UprightBox& box) {
  return {box.center_in_scan, box.size_m, box.azimuth_rad};
}

CropLasso RegionOf(const ProposeCropCommand& command) {
  CropLasso lasso;
  lasso.scan_from_cam = command.scan_from_cam;
  lasso.camera = {static_cast<int>(2 * command.center_px.x()),
                  static_cast<int>(2 * command.center_px.y()),
                  command.focal_px,
                  command.focal_px,
                  command.center_px.x(),
                  command.center_px.y()};
  lasso.polygon_px = command.polygon_px;
  return lasso;
}

}  // namespace

void AnnotationSession::On(const FitBoxCommand& command) {
  if (scan_.target == nullptr) return;
  const auto fitted =
      BoxAround(*scan_.target, command.point_in_scan,
                {up_in_scan(), project_->document().floor_in_scan, command.view_azimuth_rad});
  if (!fitted) {
    view_.fitted_box = std::make_shared<const FittedBoxView>();
    return Answer("No box was fitted: " + fitted.error().message + ". Fit it by its discs.");
  }
  view_.fitted_box = std::make_shared<const FittedBoxView>(
      FittedBoxView{UprightBox{fitted->center_in_scan, fitted->size_m, fitted->azimuth_rad}});
}

/// In what is drawn, not in the whole scan: it follows the mouse.
void AnnotationSession::On(const ShowBoxCommand& command) {
  constexpr double kFloorThickness_m = 0.02;
  view_.box.reset();
  if (!command.box || view_.scan == nullptr) return;
  Crop crop;
  crop.region = RegionOf(*command.box);
  crop.up_in_scan = up_in_scan();
  const auto& floor = project_->document().floor_in_scan;
  const Eigen::Matrix3d box_from_scan =
      UprightFrame(-up_in_scan()).WorldFromObjectRotation(command.box->azimuth_rad).transpose();
  auto points = std::make_shared<std::vector<Eigen::Vector3f>>();
  BoxView view;
  for (const int i : PointsInRegion(*view_.scan, crop)) {
    const Eigen::Vector3f& point = view_.scan->vertices[static_cast<std::size_t>(i)];
    points->push_back(point);
    const Eigen::Vector3d in_scan = point.cast<double>();
    if (floor && floor->head<3>().dot(in_scan) + (*floor)[3] < kFloorThickness_m) continue;
    view.bounds.extend(Eigen::Vector3d(box_from_scan * (in_scan - command.box->center_in_scan)));
  }
  view.points = std::move(points);
  view_.box = std::move(view);
}

void AnnotationSession::On(const ProposeCropCommand& command) {
  if (scan_.full == nullptr) return Refuse("There is no scan to cut from.");
  Crop crop;
  crop.id = command.id;
  crop.category = command.category;
  crop.into = command.fragment ? Crop::Into::kFragment : Crop::Into::kModel;
  crop.annotator = view_.annotator;
  if (command.box) {
    crop.region = RegionOf(*command.box);
  } else {
    crop.region = RegionOf(command);
  }
  DropProposals();
  view_.crop = CropView{command.id};
  const AnnotationDocument& document = project_->document();
  Propose({"Cutting out " + command.id, true,
           [crop, document, scan = scan_.full, file = project_->Resolve(document.scan),
            models = project_->Resolve(document.models),
            up = up_in_scan()](const WorkContext&, const auto&) -> Update {
             auto prepared = PrepareCrop(*scan, file, crop, document, models);
             CropView view{crop.id};
             view.running = false;
             std::shared_ptr<const PreparedCrop> kept;
             if (!prepared) {
               view.problem = prepared.error().message;
             } else {
               Show(*prepared, *scan, up, document.floor_in_scan, view);
               kept = std::make_shared<const PreparedCrop>(std::move(*prepared));
             }
             return [view, kept](AnnotationSession& session) {
               session.view_.crop = view;
               session.prepared_crop_ = kept;
             };
           }});
}

/// The model is staged before the edit that uses it; where it cannot be, nothing happens.
bool AnnotationSession::TakeCrop() {
  if (prepared_crop_ == nullptr || view_.crop->running) return false;
  const PreparedCrop prepared = *prepared_crop_;
  if (prepared.model) {
    const auto folder = project_->Resolve(project_->document().models);
    if (folder.empty()) {
      Refuse("There is no model database to put it into. Open the scan with --models FOLDER.");
      return false;
    }
    if (const Status stored = StageCropModel(prepared.model->built, folder); !stored.ok()) {
      Refuse(stored.error().message);
      return false;
    }
  }
  if (!Edit(prepared.edit)) return false;
  for (const plumbline::Edit& edit : prepared.edit.edits) {
    if (const auto* add = std::get_if<AddInstance>(&edit)) view_.selected = add->instance.id;
  }
  Answer(view_.crop->id + " cut out");
  FollowCrops();
  return true;
}

/// Models come and go with the crops that made them.
void AnnotationSession::FollowCrops() {
  const auto changed = SyncCropModels(*project_);
  if (!changed) return Refuse(changed.error().message);
  if (!*changed) return;
  surfaces_.clear();
  QueueModels();
}

}  // namespace plumbline
