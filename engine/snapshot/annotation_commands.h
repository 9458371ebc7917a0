// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the Annotate workspace asks for. Points and poses are in the frame of the scan's file.

#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/annotation/annotated_instance.h"
#include "engine/annotation/project_state.h"
#include "engine/annotation/refine_by.h"
#include "engine/snapshot/upright_box.h"

namespace plumbline {

/// "": nothing.
struct SelectInstanceCommand {
  std::string id;
};
/// Looks for the floor, from a point on it or by itself, and proposes it.
struct FindFloorCommand {
  std::optional<Eigen::Vector3d> seed_in_scan;
};
/// Proposes an up that was typed; any length > 0.
struct TypeGravityCommand {
  Eigen::Vector3d up_in_scan{0, 0, 1};
  std::optional<double> floor_offset_m;  ///< up . x + offset = 0 on the floor, for up of length 1.
};
/// Where a model stands; the answer is a PlacementView with candidates.
struct PlaceModelCommand {
  std::string model;
  Eigen::Vector3d point_in_scan{0, 0, 0};
  double view_azimuth_rad = 0;  ///< From where the pictures of the candidates are taken (level).
  bool on_floor = true;         ///< Keeps models that stand on the floor exactly on it.
};
/// Tries all azimuths again for an instance, from where it is.
struct PlaceAgainCommand {
  std::string id;
  double view_azimuth_rad = 0;
  bool on_floor = true;
};
/// Aligns an instance from exactly where it is, to the scan and to the edges of its key frames.
struct RefineInstanceCommand {
  std::string id;
  bool on_floor = true;  ///< The height stays.
  RefineBy by = RefineBy::kBoth;
};
/// Of what the refinement found, proposes another one.
struct ChooseRefinementCommand {
  RefineBy by = RefineBy::kBoth;
};
/// An instance on its way, or a candidate that is looked at, to be checked in the images; the
/// project does not change.
struct PreviewPoseCommand {
  std::string id;  ///< That of PlacementView for a candidate.
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
};
/// Takes the floor, the placement's candidate or the refinement that is proposed.
struct AcceptProposalCommand {
  std::optional<int> candidate;  ///< PlacementCandidate::id; nothing: the first.
};
/// Drops what is proposed and stops what runs for it.
struct CancelProposalCommand {};

struct InstancePose {
  std::string id;
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
};
/// One edit.
struct SetInstancePoseCommand {
  std::string id;
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
  std::vector<InstancePose> and_also = {};  ///< Further ones.
};
/// Changes what is set, of all of them as one edit; the category follows the model.
struct ChangeInstanceCommand {
  std::string id;
  InstanceChange set;
  std::vector<std::string> and_also;  ///< Further ids.
};
/// One edit.
struct RemoveInstanceCommand {
  std::string id;
  std::vector<std::string> and_also;  ///< Further ids.
};
/// The copy gets an id of its own, stands beside it on a free side, and is selected. One edit.
struct DuplicateInstanceCommand {
  std::string id;
  std::vector<std::string> and_also = {};  ///< Further ids, of which copies are made as well.
};
struct UndoCommand {};
struct RedoCommand {};
/// "": where it is.
struct SaveProjectCommand {
  std::string file;
};
/// Takes back what was recovered from a process that was killed; Redo brings it again.
struct DropRecoveredCommand {};
/// What the numbers of the scan's file are, if they are no metres: a copy in metres takes its
/// place. 1: they are metres.
struct SetScanUnitCommand {
  double metres_per_unit = 1;
};
/// Writes the annotations in another format; asks first where that would replace something else.
struct ExportCommand {
  std::string format;             ///< Of kExportFormats.
  std::string out;                ///< A file or a folder.
  std::string frame = "scan";     ///< or "level", "world"
  int every = 1;                  ///< Every Nth frame of the sequence is written, N > 0.
  bool despite_findings = false;  ///< Else it asks first where errors are open.
};
/// Compares every object with its images, for the checklist; seconds each.
struct CompareAllCommand {};
/// Says that a finding of the checklist is all right, or that it is not any more.
struct AcceptFindingCommand {
  std::string kind;  ///< Of FindingView, as are the instances.
  std::vector<std::string> instances;
  bool accepted = true;
  std::string note;  ///< Why; may be empty.
};
/// Compares it with what another annotator placed in this scan, after every edit anew; "": no more.
struct CompareWithCommand {
  std::string file;  ///< A project, or a ground truth in the frame of the scan.
};
/// Whether an export may replace what it asked about.
struct AnswerExportCommand {
  bool replace = false;
};
/// Somebody is at work: the time since the last one counts for the selected object or, while a
/// model is chosen to be placed, for the next one.
struct ActivityCommand {
  bool placing = false;
};
/// How far the work is, as the annotator says.
struct SetStageCommand {
  WorkStage stage = WorkStage::kInWork;
  std::string note;
};
/// Reads the scans and projects of a folder; "": of the one that was chosen last.
struct ListQueueCommand {
  std::string folder;
};
struct SetAnnotatorCommand {
  std::string name;
};
/// Adds the objects of a run (.plb, or its JSON) as coarse instances, in one step.
struct ImportDraftsCommand {
  std::string run;
};
struct DismissNoticesCommand {};
/// Reads a frame of the sequence, to pick in it.
struct ShowFrameCommand {
  int frame = 0;
  bool masks = false;  ///< Also which object shows at each pixel: a tenth of a second for each.
};
/// The same point in the scan and in a frame.
struct AddPairCommand {
  Eigen::Vector3d in_scan{0, 0, 0};
  int frame = 0;
  Eigen::Vector2d pixel{0, 0};
};
/// Fits a box to the thing that a point of the scan belongs to; the answer is a FittedBoxView.
struct FitBoxCommand {
  Eigen::Vector3d point_in_scan{0, 0, 0};
  double view_azimuth_rad = 0;  ///< From where it is seen: the box's front is the side towards it.
};
/// Tells which points of the scan a box holds; nothing: it is gone.
struct ShowBoxCommand {
  std::optional<UprightBox> box;
};
/// Cuts what lies inside a box, or inside a line in a view, out of the scan, and proposes it.
struct ProposeCropCommand {
  std::string id, category;
  bool fragment = false;                    ///< Of a VISMA folder; else a model of the database.
  std::optional<UprightBox> box;            ///< Nothing: the line.
  std::vector<Eigen::Vector2d> polygon_px;  ///< 3 or more corners.
  Eigen::Isometry3d scan_from_cam = Eigen::Isometry3d::Identity();  ///< Of the view.
  double focal_px = 1;
  Eigen::Vector2d center_px{0, 0};
};
struct RemovePairCommand {
  std::size_t index = 0;
};
/// Looks for where the world of the sequence is in the scan, and proposes it.
struct AlignSequenceCommand {
  enum class How { kPairs, kPoints, kObjects };
  How how = How::kPairs;
  std::string file;  ///< Of the points (.ply, .pcd), or the run with the objects.
};

/// For the process that annotates.
using AnnotationCommand =
    std::variant<SelectInstanceCommand, FindFloorCommand, TypeGravityCommand, PlaceModelCommand,
                 PlaceAgainCommand, RefineInstanceCommand, ChooseRefinementCommand,
                 PreviewPoseCommand, AcceptProposalCommand, CancelProposalCommand,
                 SetInstancePoseCommand, ChangeInstanceCommand, RemoveInstanceCommand,
                 DuplicateInstanceCommand, UndoCommand, RedoCommand, SaveProjectCommand,
                 SetAnnotatorCommand, ImportDraftsCommand, DismissNoticesCommand, ShowFrameCommand,
                 AddPairCommand, RemovePairCommand, AlignSequenceCommand, FitBoxCommand,
                 ShowBoxCommand, DropRecoveredCommand, ExportCommand, CompareAllCommand,
                 AnswerExportCommand, SetScanUnitCommand, ProposeCropCommand, ActivityCommand,
                 SetStageCommand, ListQueueCommand, AcceptFindingCommand, CompareWithCommand>;

}  // namespace plumbline
