// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/annotation/annotation_check.h"
#include "engine/annotation/crop_cut.h"
#include "engine/annotation/staged_export.h"
#include "engine/base/progress.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/sequence.h"
#include "engine/models/model_database.h"
#include "engine/session/annotation_checks.h"
#include "engine/session/annotation_jobs.h"
#include "engine/session/annotation_opening.h"
#include "engine/session/sequence_registration.h"
#include "engine/session/work_time.h"
#include "engine/snapshot/annotation_commands.h"
#include "engine/snapshot/annotation_snapshot.h"

namespace plumbline {

/// What goes on in the Annotate workspace: a project, its scan and models, and what is proposed to
/// the user. Single-threaded and without queues; long work is handed out as jobs whose results come
/// back as updates. The same commands and updates in the same order give the same project.
class AnnotationSession {
 public:
  using Update = std::function<void(AnnotationSession&)>;
  /// Work for another thread: `emit` tells how far it is, the result is what it found.
  struct Job {
    std::string stage;
    bool can_cancel = false;
    std::function<Update(const WorkContext& work, const std::function<void(Update)>& emit)> run;
  };
  /// Seconds since whenever: time spent is counted by it.
  using Clock = std::function<double()>;

  /// Errors: of OpenAnnotation.
  static Result<std::unique_ptr<AnnotationSession>> Open(const AnnotationChoice& choice,
                                                         Clock clock = SteadySeconds,
                                                         int refine_pace_ms = 30);
  static double SteadySeconds();

  /// @param number  By which the snapshot tells that it was carried out; 0: nobody asks.
  void Apply(const AnnotationCommand& command, std::uint64_t number = 0);
  /// The next long work, if any; one at a time is meant to run.
  std::optional<Job> TakeJob();
  /// At the end: the project's file gets what is only in the journal, so that nothing has to be
  /// recovered. What cannot be saved stays in the journal.
  void Close();
  /// Whether the job that runs is no longer wanted; asked once.
  bool TakeCancel() { return std::exchange(cancel_, false); }
  AnnotationSnapshot Snapshot() const;
  const AnnotationProject& project() const { return *project_; }

 private:
  AnnotationSession(OpenedAnnotation opened, const AnnotationChoice& choice, Clock clock,
                    int refine_pace_ms);

  void On(const SelectInstanceCommand& command);
  void On(const FindFloorCommand& command);
  void On(const TypeGravityCommand& command);
  void On(const PlaceModelCommand& command);
  void On(const PlaceAgainCommand& command);
  void On(const RefineInstanceCommand& command);
  void On(const ChooseRefinementCommand& command);
  void On(const PreviewPoseCommand& command);
  void On(const AcceptProposalCommand& command);
  void On(const CancelProposalCommand& command);
  void On(const SetInstancePoseCommand& command);
  void On(const ChangeInstanceCommand& command);
  void On(const RemoveInstanceCommand& command);
  void On(const DuplicateInstanceCommand& command);
  void On(const UndoCommand& command);
  void On(const RedoCommand& command);
  void On(const SaveProjectCommand& command);
  void On(const DropRecoveredCommand& command);
  void On(const ExportCommand& command);
  void On(const CompareAllCommand& command);
  void On(const AcceptFindingCommand& command);
  void On(const CompareWithCommand& command);
  void On(const AnswerExportCommand& command);
  void On(const SetScanUnitCommand& command);
  void On(const SetAnnotatorCommand& command);
  void On(const ImportDraftsCommand& command);
  void On(const DismissNoticesCommand& command);
  void On(const ShowFrameCommand& command);
  void On(const AddPairCommand& command);
  void On(const RemovePairCommand& command);
  void On(const AlignSequenceCommand& command);
  void On(const FitBoxCommand& command);
  void On(const ShowBoxCommand& command);
  void On(const ProposeCropCommand& command);
  void On(const ActivityCommand& command);
  void On(const SetStageCommand& command);
  void On(const ListQueueCommand& command);
  bool TakeCrop();
  bool TakeRefinement();
  void FollowCrops();

  void QueueLoading();
  void QueueScan();
  /// Reads the scan that the project names now, if it is another one.
  void FollowScan();
  void TakeScan(const AnnotationScan& scan);
  void QueueModels();
  void WarnOfLargeModels(const std::vector<AnnotationModel>& models);
  void QueueThumbnails();
  void QueueTarget();
  void QueueOutlines();
  /// Asks for the images of the selected object, or for its outline in them, if they are not those
  /// of where it is now.
  void WantChecks();
  Eigen::Isometry3d JudgedPoseNow() const;
  std::vector<ComparedPose> ComparedPoses() const;
  void TakeImages(const PlacementQuestion& question, std::uint64_t asked_by,
                  const PlacementImages& chosen);
  Job ImagesJob();
  bool AuditDue() const;
  Job AuditJob();
  bool AgreementDue() const;
  Job AgreementJob();
  void MakeChecklist();
  std::vector<AnnotationFinding> AgreementFindings() const;
  Job CheckJob();
  Job FrameJob(int frame);
  void SetChange(SequenceAlignmentView& view) const;
  std::optional<Eigen::Isometry3d> ScanFromWorldNow() const;
  std::vector<Eigen::Vector3d> CamerasInScan() const;
  void AddSequence(AnnotationSnapshot& snapshot) const;
  void QueuePlacement(PlacementTask task, int model, std::string instance);
  std::optional<PlacementTask> TaskFor(int model, const Eigen::Isometry3d& pose, bool on_floor,
                                       double scale = 1);
  void Propose(Job job);
  void DropProposals();
  bool Edit(const plumbline::Edit& edit);
  void Answer(std::string text, bool refused = false);
  void Refuse(const std::string& text) { Answer(text, true); }
  /// On what somebody works now, as WorkTime counts it.
  std::optional<std::string> WorkedOn() const;
  /// The edit together with the time that was spent on objects meanwhile.
  plumbline::Edit WithTimeSpent(const plumbline::Edit& edit) const;
  /// What was spent since the last edit, at the end of a sitting: more than a glance at something
  /// that is not done.
  void WriteTimeSpent();
  /// Undo and redo take no time back that was spent.
  void KeepTimeSpent(const std::vector<AnnotatedInstance>& before);
  Eigen::Isometry3d PoseOf(const std::string& id) const;
  Eigen::Vector3d up_in_scan() const { return -project_->document().gravity_in_scan; }
  FloorHints Hints() const;

  std::unique_ptr<AnnotationProject> project_;
  Clock clock_;
  int refine_pace_ms_;
  WorkTime work_time_;
  bool placing_ = false;  ///< A model is chosen to be placed.
  std::filesystem::path queue_folder_;
  AnnotationSnapshot view_;  ///< All but what the project says.
  std::deque<Job> jobs_;
  bool cancel_ = false;
  std::uint64_t command_ = 0;    ///< Number of the one that is carried out.
  std::uint64_t proposals_ = 0;  ///< An update of an older proposal is dropped.
  AnnotationScan scan_;
  std::filesystem::path scan_file_;       ///< That was read, or is being read.
  std::shared_ptr<StagedExport> staged_;  ///< Waits for an answer.
  std::shared_ptr<const ModelDatabase> models_;
  std::shared_ptr<const Sequence> sequence_;
  std::map<int, std::shared_ptr<const ModelSurface>> surfaces_;
  std::shared_ptr<OutlineScene> outlines_;  ///< Of jobs alone; null until it is ready.
  std::shared_ptr<const InstanceImages> images_;
  std::optional<PlacementTask> refined_on_scan_;  ///< Of `view_.refinement`.
  std::optional<Eigen::Isometry3d> preview_;      ///< Of the selected object, or a candidate.
  std::optional<Eigen::Isometry3d> checked_;      ///< The last pose that was checked.
  bool images_wanted_ = false, check_wanted_ = false;
  std::vector<AnnotationFinding> findings_;  ///< Of the project as it was audited.
  std::uint64_t audited_ = 0, audited_models_ = 0;
  struct Compared {
    Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
    double agreement = 0;
    std::size_t images = 0;
    double scale = 1;
  };
  std::map<std::string, Compared> compared_;  ///< With the images, by instance.
  std::string other_file_;                    ///< What another annotator placed; "": nobody asks.
  std::shared_ptr<const GroundTruth> other_;  ///< In the scan's frame; null until it is read.
  std::uint64_t agreed_ = 0;                  ///< The revision that was compared with it.
  std::vector<Eigen::Vector3d> cameras_in_world_;
  std::shared_ptr<const PreparedCrop> prepared_crop_;
  std::optional<int> frame_wanted_;
};

}  // namespace plumbline
