// SPDX-License-Identifier: Apache-2.0
// The part of the session that reads what the project names.
#include <fmt/format.h>

#include <utility>

#include "engine/annotation/crop_models.h"
#include "engine/render/small_picture.h"
#include "engine/session/annotation_session.h"

namespace plumbline {
namespace {

constexpr int kThumbnailWidth = 144, kThumbnailHeight = 108;

}  // namespace

void AnnotationSession::QueueLoading() {
  const AnnotationDocument& document = project_->document();
  if (const auto file = project_->Resolve(document.sequence); !file.empty()) {
    if (auto opened = OpenSequence(file); opened.ok()) {
      sequence_ = std::move(*opened);
      for (int i = 0; i < sequence_->num_frames(); ++i) {
        if (const auto pose = sequence_->world_from_cam(i)) {
          cameras_in_world_.push_back(pose->translation());
        }
      }
    } else {
      view_.notices.push_back("The sequence is not used: " + opened.error().message);
    }
  }
  if (!view_.read_only) {
    const auto synced = SyncCropModels(*project_);
    if (!synced) view_.notices.push_back("Models of crops: " + synced.error().message);
  }
  QueueModels();
  QueueScan();
}

void AnnotationSession::FollowScan() {
  if (project_->Resolve(project_->document().scan) == scan_file_) return;
  view_.ready_to_align = false;
  view_.doubted_size_m.reset();
  QueueScan();
}

void AnnotationSession::QueueScan() {
  const auto file = scan_file_ = project_->Resolve(project_->document().scan);
  if (file.empty()) return;
  view_.scan_name = file.filename().string();
  jobs_.push_back({"Reading the scan", false, [file](const WorkContext&, const auto&) -> Update {
                     auto read = ReadAnnotationScan(file);
                     return [read = std::move(read), file](AnnotationSession& session) {
                       if (file != session.scan_file_) return;  // another one is wanted by now
                       if (!read) {
                         session.view_.notices.push_back("The scan cannot be shown: " +
                                                         read.error().message);
                         return session.QueueOutlines();
                       }
                       session.TakeScan(*read);
                     };
                   }});
}

void AnnotationSession::TakeScan(const AnnotationScan& scan) {
  scan_ = scan;
  view_.scan = scan.fine;
  view_.scan_coarse = scan.coarse;
  view_.scan_points = scan.full->vertices.size();
  if (scan.num_left_out > 0) {
    view_.notices.push_back(fmt::format("{} of {} points of {} are not finite and were left out.",
                                        scan.num_left_out, scan.num_left_out + view_.scan_points,
                                        view_.scan_name));
  }
  // Where objects have been placed, somebody has found that it is right as it is.
  if (project_->document().instances.empty()) view_.doubted_size_m = scan.doubted_size_m;
  QueueTarget();
  QueueOutlines();
}

void AnnotationSession::QueueTarget() {
  jobs_.push_front(
      {"Preparing the scan", false,
       [scan = scan_.full, cameras = CamerasInScan()](const WorkContext&, const auto&) -> Update {
         auto target = ScanTarget::Prepare(*scan, cameras);
         return [target](AnnotationSession& session) {
           if (!target) return session.Refuse(target.error().message);
           session.scan_.target = *target;
           session.view_.ready_to_align = true;
         };
       }});
}

void AnnotationSession::QueueModels() {
  const auto folder = project_->Resolve(project_->document().models);
  if (folder.empty()) {
    view_.models_problem = "No model database was named. Open the scan with --models FOLDER.";
    return;
  }
  jobs_.push_back(
      {"Reading the models", false, [folder](const WorkContext&, const auto&) -> Update {
         auto loaded = ModelDatabase::Load(folder);
         return [loaded](AnnotationSession& session) {
           if (!loaded) {
             session.view_.models_problem = loaded.error().message;
             return;
           }
           session.models_ = *loaded;
           auto models = std::make_shared<std::vector<AnnotationModel>>();
           for (const CadModel& model : session.models_->models()) {
             models->push_back({model.name,
                                model.category,
                                std::make_shared<const TriangleMesh>(model.mesh),
                                model.bounds,
                                model.support == Support::kFloor,
                                model.symmetry.order,
                                {}});
           }
           session.WarnOfLargeModels(*models);
           session.view_.models = std::move(models);
           ++session.view_.models_version;
           session.QueueThumbnails();
           if (session.view_.scan_name.empty() || session.outlines_ != nullptr) {
             session.QueueOutlines();
           }
         };
       }});
}

void AnnotationSession::WarnOfLargeModels(const std::vector<AnnotationModel>& models) {
  constexpr float kLargest_m = 30;
  for (const AnnotationModel& model : models) {
    const float size_m = model.bounds.sizes().maxCoeff();
    if (size_m < kLargest_m) continue;
    view_.notices.push_back(
        fmt::format("The model '{}' is {:.0f} m large, as if millimetres had been taken for "
                    "metres: build the database again with 'plumbline models build --unit mm'.",
                    model.name, size_m));
    return;
  }
}

void AnnotationSession::QueueThumbnails() {
  jobs_.push_back({"Drawing the models", false,
                   [models = view_.models](const WorkContext& work, const auto&) -> Update {
                     auto drawn = std::make_shared<std::vector<AnnotationModel>>(*models);
                     for (AnnotationModel& model : *drawn) {
                       if (work.stop.stop_requested()) break;
                       model.thumbnail =
                           ModelPicture(*model.mesh, kThumbnailWidth, kThumbnailHeight);
                     }
                     return [drawn](AnnotationSession& session) {
                       session.view_.models = drawn;
                       ++session.view_.models_version;
                     };
                   }});
}

}  // namespace plumbline
