// SPDX-License-Identifier: Apache-2.0
#include "engine/process/annotation_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "engine/annotation/pose_exchange.h"
#include "engine/geometry/gravity.h"
#include "engine/process/run_drafts.h"
#include "engine/process/small_picture.h"

namespace plumbline {
namespace {

constexpr int kThumbnailWidth = 144, kThumbnailHeight = 108;
constexpr double kLongestPause_s = 90;  ///< Longer pauses are not time spent.

InstanceView ViewOf(const AnnotatedInstance& instance, const ModelDatabase* models) {
  InstanceView view;
  view.id = instance.id;
  view.model = instance.model;
  view.category = instance.category;
  view.note = instance.note;
  view.annotator = instance.annotator;
  view.scan_from_object = instance.scan_from_object;
  view.fine = instance.fine;
  view.hidden = instance.hidden;
  view.locked = instance.locked;
  view.seconds_spent = instance.seconds_spent;
  if (models != nullptr) {
    if (const auto found = models->Find(instance.model)) view.model_index = found->value;
  }
  return view;
}

}  // namespace

double AnnotationSession::SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Result<std::unique_ptr<AnnotationSession>> AnnotationSession::Open(const AnnotationChoice& choice,
                                                                   Clock clock,
                                                                   int refine_pace_ms) {
  auto opened = OpenAnnotation(choice);
  if (!opened) return opened.error();
  return std::unique_ptr<AnnotationSession>(
      new AnnotationSession(std::move(*opened), choice, std::move(clock), refine_pace_ms));
}

AnnotationSession::AnnotationSession(OpenedAnnotation opened, const AnnotationChoice& choice,
                                     Clock clock, int refine_pace_ms)
    : project_(std::move(opened.project)),
      clock_(std::move(clock)),
      refine_pace_ms_(refine_pace_ms),
      last_edit_s_(clock_()) {
  view_.state = AnnotationSnapshot::State::kReady;
  view_.read_only = opened.read_only;
  view_.notices = std::move(opened.notices);
  view_.annotator = choice.annotator;
  const AnnotationDocument& document = project_->document();
  view_.gravity_known =
      document.floor_in_scan.has_value() || document.gravity_in_scan != Eigen::Vector3d(0, 0, -1);
  QueueLoading();
}

std::optional<AnnotationSession::Job> AnnotationSession::TakeJob() {
  if (frame_wanted_) return FrameJob(*std::exchange(frame_wanted_, std::nullopt));
  if (jobs_.empty() && std::exchange(check_wanted_, false)) return CheckJob();
  if (jobs_.empty() && std::exchange(images_wanted_, false)) return ImagesJob();
  if (jobs_.empty()) return std::nullopt;
  Job job = std::move(jobs_.front());
  jobs_.pop_front();
  return job;
}

void AnnotationSession::Apply(const AnnotationCommand& command) {
  std::visit([this](const auto& c) { On(c); }, command);
  if (!std::holds_alternative<PreviewPoseCommand>(command)) {
    preview_.reset();
    checked_.reset();  // what hides it may have changed
  }
  WantChecks();
}

void AnnotationSession::Answer(std::string text, bool refused) {
  view_.answer = std::move(text);
  view_.refused = refused;
  ++view_.answer_number;
}

bool AnnotationSession::Edit(const plumbline::Edit& edit) {
  const Status done = project_->Apply(edit);
  if (done.ok()) return true;
  Refuse(done.error().message);
  return false;
}

/// Counted with the edit that it led to.
double AnnotationSession::SpentSinceLastEdit() {
  const double now = clock_();
  const double spent = std::min(now - last_edit_s_, kLongestPause_s);
  last_edit_s_ = now;
  return std::round(10 * spent) / 10;
}

std::string AnnotationSession::FreeId(const std::string& model) const {
  for (int i = 0;; ++i) {
    std::string id = model + "_" + std::to_string(i);
    if (project_->document().Find(id) == nullptr) return id;
  }
}

// Loading.

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
  QueueModels();
  const auto file = project_->Resolve(document.scan);
  if (file.empty()) return;
  view_.scan_name = file.filename().string();
  jobs_.push_back({"Reading the scan", false, [file](const WorkContext&, const auto&) -> Update {
                     auto read = ReadAnnotationScan(file);
                     return [read = std::move(read)](AnnotationSession& session) {
                       if (!read) {
                         session.view_.notices.push_back("The scan cannot be shown: " +
                                                         read.error().message);
                         return session.QueueOutlines();
                       }
                       session.scan_ = *read;
                       session.view_.scan = read->fine;
                       session.view_.scan_coarse = read->coarse;
                       session.view_.scan_points = read->full->vertices.size();
                       session.QueueTarget();
                       session.QueueOutlines();
                     };
                   }});
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
           session.view_.models = std::move(models);
           ++session.view_.models_version;
           session.QueueThumbnails();
           if (session.view_.scan_name.empty() || session.outlines_ != nullptr) {
             session.QueueOutlines();
           }
         };
       }});
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

// Proposals.

void AnnotationSession::DropProposals() {
  view_.floor.reset();
  view_.placement.reset();
  view_.refinement.reset();
  view_.sequence_alignment.reset();
  view_.crop.reset();
  prepared_crop_.reset();
  ++view_.proposal_number;
  ++proposals_;
  std::erase_if(jobs_, [](const Job& job) { return job.can_cancel; });
  cancel_ = true;
}

/// Runs before everything that waits; its updates count only while nothing else is proposed.
void AnnotationSession::Propose(Job job) {
  job.can_cancel = true;
  const std::uint64_t number = proposals_;
  const auto guarded = [number](Update update) -> Update {
    return [number, update = std::move(update)](AnnotationSession& session) {
      if (session.proposals_ != number) return;
      update(session);
      ++session.view_.proposal_number;
    };
  };
  job.run = [guarded, run = std::move(job.run)](const WorkContext& work,
                                                const std::function<void(Update)>& emit) -> Update {
    return guarded(run(work, [&](Update update) { emit(guarded(std::move(update))); }));
  };
  jobs_.push_front(std::move(job));
}

FloorHints AnnotationSession::Hints() const {
  FloorHints hints;
  hints.camera_centers = CamerasInScan();
  return hints;
}

void AnnotationSession::On(const FindFloorCommand& command) {
  if (scan_.target == nullptr) return Refuse("The scan is still being prepared.");
  DropProposals();
  Propose({"Looking for the floor", true,
           [target = scan_.target, seed = command.seed_in_scan, hints = Hints(), up = up_in_scan()](
               const WorkContext&, const auto&) -> Update {
             auto floor = ProposeFloor(*target, seed, hints, up);
             return [floor](AnnotationSession& session) {
               if (!floor) return session.Refuse(floor.error().message);
               session.view_.floor = *floor;
             };
           }});
}

void AnnotationSession::On(const TypeGravityCommand& command) {
  if (!(command.up_in_scan.norm() > 1e-6)) return Refuse("Up needs a length: type three numbers.");
  DropProposals();
  FloorProposal proposal;
  proposal.source = "typed";
  proposal.up_in_scan = command.up_in_scan.normalized();
  proposal.offset_m = command.floor_offset_m;
  proposal.turn_rad = std::acos(std::clamp(proposal.up_in_scan.dot(up_in_scan()), -1.0, 1.0));
  if (scan_.target != nullptr) {
    ShowFloorPoints(*scan_.target, proposal);
    proposal.num_inliers = proposal.inliers->size();
  }
  view_.floor = std::move(proposal);
}

/// Nothing, with an answer, if it cannot be done now.
std::optional<PlacementTask> AnnotationSession::TaskFor(int model, const Eigen::Isometry3d& pose,
                                                        bool on_floor) {
  const AnnotationModel* view = view_.Model(model);
  if (view == nullptr) {
    Refuse("The database has no such model.");
    return std::nullopt;
  }
  if (scan_.target == nullptr) {
    Refuse(view_.scan_name.empty() ? "There is no scan to align to."
                                   : "The scan is still being prepared.");
    return std::nullopt;
  }
  if (surfaces_[model] == nullptr) {
    auto surface = ModelSurface::Prepare(*view->mesh);
    if (!surface) {
      Refuse(view->name + ": " + surface.error().message);
      return std::nullopt;
    }
    surfaces_[model] = std::move(*surface);
  }
  PlacementTask task;
  task.target = scan_.target;
  task.scan = scan_.full;
  task.surface = surfaces_[model];
  task.mesh = view->mesh;
  task.scan_from_object = pose;
  task.up_in_scan = up_in_scan();
  task.stands = on_floor && view->on_floor;
  if (task.stands) task.floor_in_scan = project_->document().floor_in_scan;
  return task;
}

void AnnotationSession::QueuePlacement(PlacementTask task, int model, std::string instance) {
  DropProposals();
  PlacementView placement;
  placement.model = model;
  placement.instance = std::move(instance);
  view_.placement = placement;
  Propose({"Trying 24 azimuths", true,
           [task = std::move(task), placement](const WorkContext& work, const auto&) -> Update {
             PlacementView found = placement;
             FindPlacements(task, work, found);
             return [found](AnnotationSession& session) { session.view_.placement = found; };
           }});
}

void AnnotationSession::On(const PlaceModelCommand& command) {
  const auto id = models_ != nullptr ? models_->Find(command.model) : std::nullopt;
  const int model = id ? id->value : -1;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = UprightFrame(-up_in_scan()).upright_rotation();
  pose.translation() = command.point_in_scan;
  auto task = TaskFor(model, pose, command.on_floor);
  if (!task) return;
  if (const auto& floor = task->floor_in_scan) {  // a click on the seat means what is below it
    const Eigen::Vector3d up = floor->head<3>();
    task->scan_from_object.translation() -= up * (up.dot(command.point_in_scan) + (*floor)[3]);
  }
  task->view_azimuth_rad = command.view_azimuth_rad;
  QueuePlacement(std::move(*task), model, "");
}

void AnnotationSession::On(const PlaceAgainCommand& command) {
  const AnnotatedInstance* instance = project_->document().Find(command.id);
  if (instance == nullptr || models_ == nullptr) return Refuse("Select an object first.");
  if (instance->locked) return Refuse("'" + command.id + "' is locked; unlock it first.");
  const auto id = models_->Find(instance->model);
  auto task = TaskFor(id ? id->value : -1, instance->scan_from_object, command.on_floor);
  if (!task) return;
  task->view_azimuth_rad = command.view_azimuth_rad;
  QueuePlacement(std::move(*task), id->value, command.id);
}

void AnnotationSession::On(const RefineInstanceCommand& command) {
  const AnnotatedInstance* instance = project_->document().Find(command.id);
  if (instance == nullptr || models_ == nullptr) return Refuse("Select an object first.");
  if (instance->locked) return Refuse("'" + command.id + "' is locked; unlock it first.");
  const auto id = models_->Find(instance->model);
  const auto task = TaskFor(id ? id->value : -1, instance->scan_from_object, command.on_floor);
  if (!task) return;
  DropProposals();
  RefinementView refinement;
  refinement.instance = command.id;
  refinement.scan_from_object = instance->scan_from_object;
  view_.refinement = refinement;
  Propose({"Refining " + command.id, true,
           [task = *task, refinement, pace = refine_pace_ms_](const WorkContext& work,
                                                              const auto& emit) -> Update {
             RefinementView now = refinement;
             const auto step = [&](const RefinementView& view) {
               emit([view](AnnotationSession& session) { session.view_.refinement = view; });
             };
             Refine(task, work, pace, step, now);
             return [now](AnnotationSession& session) {
               session.view_.refinement = now;
               session.preview_ = now.scan_from_object;
               session.WantChecks();
             };
           }});
}

void AnnotationSession::On(const AcceptProposalCommand& command) {
  if (const auto& floor = view_.floor) {
    SetGravity edit{-floor->up_in_scan, std::nullopt};
    if (floor->offset_m) {
      edit.floor_in_scan = Eigen::Vector4d(floor->up_in_scan.x(), floor->up_in_scan.y(),
                                           floor->up_in_scan.z(), *floor->offset_m);
    }
    if (!Edit(edit)) return;
    view_.gravity_known = true;
  } else if (const auto& placement = view_.placement) {
    if (placement->running || placement->candidates.empty()) return;
    const auto chosen = static_cast<std::size_t>(
        std::clamp(command.candidate, 0, static_cast<int>(placement->candidates.size()) - 1));
    const Eigen::Isometry3d pose = placement->candidates[chosen].scan_from_object;
    if (placement->instance.empty()) {
      const AnnotationModel& model = *view_.Model(placement->model);
      AnnotatedInstance instance;
      instance.id = FreeId(model.name);
      instance.model = model.name;
      instance.category = model.category;
      instance.scan_from_object = pose;
      instance.annotator = view_.annotator;
      instance.fine = placement->problem.empty();
      instance.seconds_spent = SpentSinceLastEdit();
      if (!Edit(AddInstance{instance, std::nullopt})) return;
      view_.selected = instance.id;
    } else {
      On(SetInstancePoseCommand{placement->instance, pose});
    }
  } else if (const auto& refinement = view_.refinement) {
    On(SetInstancePoseCommand{refinement->instance, refinement->scan_from_object});
  } else if (const auto& alignment = view_.sequence_alignment) {
    if (alignment->running || !alignment->problem.empty()) return;
    if (!Edit(SetSceneAlignment{alignment->scan_from_world})) return;
  } else if (view_.crop) {
    if (!TakeCrop()) return;
  } else {
    return;
  }
  DropProposals();
}

void AnnotationSession::On(const CancelProposalCommand&) { DropProposals(); }

// Edits.

void AnnotationSession::On(const SelectInstanceCommand& command) {
  if (view_.refinement && view_.refinement->instance != command.id) DropProposals();
  view_.selected = command.id;
}

void AnnotationSession::On(const SetInstancePoseCommand& command) {
  const AnnotatedInstance* instance = project_->document().Find(command.id);
  if (instance == nullptr) return Refuse("There is no object '" + command.id + "'.");
  if (view_.refinement) DropProposals();
  ChangeInstance edit;
  edit.id = command.id;
  edit.scan_from_object = command.scan_from_object;
  edit.seconds_spent = instance->seconds_spent + SpentSinceLastEdit();
  Edit(edit);
}

void AnnotationSession::On(const ChangeInstanceCommand& command) {
  ChangeInstance edit;
  edit.id = command.id;
  edit.new_id = command.new_id;
  edit.note = command.note;
  edit.fine = command.fine;
  edit.hidden = command.hidden;
  edit.locked = command.locked;
  if (command.model) {
    const auto id = models_ != nullptr ? models_->Find(*command.model) : std::nullopt;
    if (!id) return Refuse("The database has no model '" + *command.model + "'.");
    edit.model = *command.model;
    edit.category = models_->model(*id).category;
  }
  if (!Edit(edit)) return;
  if (command.new_id && view_.selected == command.id) view_.selected = *command.new_id;
}

void AnnotationSession::On(const RemoveInstanceCommand& command) {
  DropProposals();
  if (Edit(RemoveInstance{command.id}) && view_.selected == command.id) view_.selected.clear();
}

void AnnotationSession::On(const DuplicateInstanceCommand& command) {
  const AnnotatedInstance* instance = project_->document().Find(command.id);
  if (instance == nullptr) return Refuse("Select an object first.");
  AnnotatedInstance copy = *instance;
  copy.id = FreeId(copy.model);
  copy.scan_from_object = command.scan_from_object;
  copy.annotator = view_.annotator;
  copy.locked = copy.hidden = false;
  copy.seconds_spent = SpentSinceLastEdit();
  if (Edit(AddInstance{copy, std::nullopt})) view_.selected = copy.id;
}

void AnnotationSession::On(const UndoCommand&) {
  DropProposals();
  const auto label = project_->UndoLabel();
  const Status done = project_->Undo();
  done.ok() ? Answer("Undone: " + label.value_or("")) : Refuse(done.error().message);
}

void AnnotationSession::On(const RedoCommand&) {
  DropProposals();
  const auto label = project_->RedoLabel();
  const Status done = project_->Redo();
  done.ok() ? Answer("Done again: " + label.value_or("")) : Refuse(done.error().message);
}

void AnnotationSession::On(const SaveProjectCommand& command) {
  const Status saved = command.file.empty() ? project_->Save() : project_->SaveAs(command.file);
  if (!saved.ok()) return Refuse(saved.error().message);
  if (!command.file.empty()) view_.read_only = false;
  Answer("Saved as " + project_->file().string());
}

void AnnotationSession::On(const SetAnnotatorCommand& command) { view_.annotator = command.name; }

void AnnotationSession::On(const DismissNoticesCommand&) { view_.notices.clear(); }

void AnnotationSession::On(const ImportDraftsCommand& command) {
  auto drafts = DraftsOfRun(project_->document(), command.run);
  if (!drafts) return Refuse(drafts.error().message);
  const std::string run = std::filesystem::path(command.run).filename().string();
  if (drafts->empty()) return Refuse(run + " has no confirmed objects.");
  const std::size_t count = drafts->size();
  EditGroup group{"Take drafts from " + run, {}};
  for (AnnotatedInstance& draft : *drafts) {
    draft.annotator = view_.annotator;
    group.edits.push_back(AddInstance{std::move(draft), std::nullopt});
  }
  if (Edit(group)) Answer(std::to_string(count) + " drafts taken from " + run);
}

AnnotationSnapshot AnnotationSession::Snapshot() const {
  AnnotationSnapshot snapshot = view_;
  const AnnotationDocument& document = project_->document();
  snapshot.project_file = project_->file().string();
  snapshot.project_name = project_->file().filename().string();
  AddSequence(snapshot);
  snapshot.modified = project_->modified();
  if (const auto& problem = project_->journal_problem())
    snapshot.journal_problem = problem->message;
  snapshot.undo_label = project_->UndoLabel();
  snapshot.redo_label = project_->RedoLabel();
  snapshot.level_from_scan = document.LevelFromScan();
  snapshot.floor_known = document.floor_in_scan.has_value();
  snapshot.gravity_known = view_.gravity_known || snapshot.floor_known;
  for (const AnnotatedInstance& instance : document.instances) {
    snapshot.instances.push_back(ViewOf(instance, models_.get()));
  }
  if (snapshot.Selected() == nullptr) snapshot.selected.clear();
  return snapshot;
}

}  // namespace plumbline
