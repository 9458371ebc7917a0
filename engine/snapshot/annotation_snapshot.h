// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the Annotate workspace sees: values only, shared and never written after publication. Poses
// and points are in the frame of the scan's file; `level_from_scan` turns them z-up with the floor
// at 0, which is how the window shows them.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/annotation/annotated_instance.h"
#include "engine/annotation/refine_by.h"
#include "engine/geometry/mesh.h"
#include "engine/snapshot/annotation_queue_view.h"
#include "engine/snapshot/upright_box.h"

namespace plumbline {

/// A shape of the database.
struct AnnotationModel {
  std::string name, category;
  std::shared_ptr<const TriangleMesh> mesh;
  Eigen::AlignedBox3f bounds;
  bool on_floor = false;   ///< Stands on the floor, not on other things.
  int symmetry_order = 1;  ///< 0: round
  cv::Mat thumbnail;       ///< CV_8UC3 BGR; empty until it is made.
};

/// A floor to accept or not.
struct FloorProposal {
  std::string source;  ///< "picked", "found" or "typed"
  Eigen::Vector3d up_in_scan{0, 0, 1};
  std::optional<double> offset_m;  ///< up . x + offset = 0 on the floor; nothing: only up is known.
  /// Points of the scan that lie on the plane, and those close to it that do not; never null.
  std::shared_ptr<const std::vector<Eigen::Vector3f>> inliers, outliers;
  std::size_t num_inliers = 0;
  double rmse_m = 0, normal_std_rad = 0;
  double turn_rad = 0;  ///< Between up and what counts as up now.
};

/// One way in which a model fits the scan.
struct PlacementCandidate {
  int id = 0;  ///< Stays, whatever the order becomes; unique in the placement.
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
  double fitness = 0;  ///< Share of the model's surface that has scan within 2 cm.
  double rmse_m = 0;   ///< Of the distances of the scan points explained.
  double azimuth_rad = 0;
  double position_std_m = 0, azimuth_std_rad = 0;
  bool same_by_symmetry = false;    ///< The first one, turned within itself.
  std::optional<double> agreement;  ///< With the images, as of ImageChecksView.
  bool from_images = false;         ///< The scan does not show it, the images do.
  cv::Mat picture;                  ///< CV_8UC3 BGR
};

/// A model on its way into the scan.
struct PlacementView {
  std::uint64_t asked_by = 0;  ///< Number of the command.
  int model = -1;
  std::string instance;  ///< The one that is placed again; "": a new one.
  bool running = true;
  double seconds = 0;   ///< That the alignment took.
  std::string problem;  ///< Why there is only the place that was clicked.
  int symmetry_order = 1;
  std::vector<PlacementCandidate> candidates;  ///< Best first.
  double scale = 1;                            ///< Of the model.
  int images = 0;                              ///< In which they were compared; 0: in none (yet).
  bool by_images = false;                      ///< The images decided which is the first.
  bool searching = false;                      ///< In the images, because none agrees with them.
};

/// A pose that a refinement found.
struct RefinedPose {
  RefineBy by = RefineBy::kBoth;
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
  bool converged = false;
  double azimuth_rad = 0, horizontal_m = 0, height_m = 0, tilt_rad = 0;  ///< Changes.
  double azimuth_std_rad = 0, horizontal_std_m = 0, height_std_m = 0;    ///< 0: not free.
  double fitness = 0, rmse_m = 0;            ///< With the scan, where there is one.
  double agreement = 0, offset_px = 0;       ///< In the images refined on, as of ImageChecksView.
  std::optional<double> agreement_held_out;  ///< In images that were not refined on.
};

/// An alignment that starts from where an instance is; as a pose, the one that is proposed.
struct RefinementView : RefinedPose {
  std::string instance;
  bool running = true;
  int iteration = 0;  ///< On the scan.
  bool has_scan = false, has_images = false;
  RefinedPose before;
  std::vector<RefinedPose> found;  ///< Together, by the scan, by the images; those that there are.
  RefinedPose apart;               ///< From the scan's to the images', as changes; deviations as
                                   ///< both expect. Where both were found.
  bool contradict = false;         ///< They are farther apart than both allow.
  std::string problem;             ///< Why nothing was found.
  std::string one_problem;         ///< Why scan or images found nothing.
  double scale = 1;                ///< Of the model, in all that was found.
  double scale_std = 0;            ///< 0: it was not free, or nothing shows it.
  std::string scale_problem;       ///< Why nothing shows it.
  /// Of every vertex of the model: distance of the nearest scan point; negative: none within 10 cm.
  std::shared_ptr<const std::vector<float>> residuals_m;
};

/// A line of a posed model in an image.
struct OutlineLine {
  bool crease = false;  ///< Else a contour.
  bool hidden = false;  ///< Behind the scan or another object.
  std::vector<Eigen::Vector2f> pixels;
};

/// What can be seen of the outline of another pose than the one that is judged.
struct OtherOutline {
  std::optional<RefineBy> by;  ///< Nothing: where it is placed.
  std::vector<std::vector<Eigen::Vector2f>> lines;
};

/// How the object that is judged lies in one key frame.
struct ImageCheckView {
  int frame = 0;
  cv::Mat image;  ///< CV_8UC3 BGR
  Eigen::Isometry3d scan_from_cam = Eigen::Isometry3d::Identity();
  std::vector<OutlineLine> lines;
  /// For comparison: where it is placed, and other results of a refinement that contradict.
  std::vector<OtherOutline> others;
  bool held_out = false;        ///< A refinement does not look at it.
  double agreement = 0;         ///< Share of the visible outline that lies on edges, beyond chance.
  double median_offset_px = 0;  ///< Of the edges from the outline.
  double visible_px = 0;
};

struct ImageChecksView {
  std::string instance;
  bool running = true;  ///< Frames are still being chosen.
  std::string problem;  ///< Why there are none.
  double agreement = 0;
  std::vector<ImageCheckView> images;
};

/// A frame to pick in.
struct FrameView {
  int frame = 0;
  cv::Mat image;  ///< CV_8UC3 BGR; empty while it is read.
  std::string problem;
  bool masks = false;  ///< Whether `instances` were asked for.
  /// Of each pixel the place of the placed object that shows there + 1, as exported masks have it;
  /// CV_16U, as large as the image. Empty if `masks_problem` says why.
  cv::Mat instances;
  std::string masks_problem;
};

/// The same point in the scan and in a frame.
struct PairView {
  Eigen::Vector3d in_scan{0, 0, 0};
  int frame = 0;
  Eigen::Vector2d pixel{0, 0};
  /// Where the point of the scan is seen by what is proposed, else by the project; nothing behind
  /// the camera.
  std::optional<Eigen::Vector2d> seen_at;
  double residual_px = 0;
};

/// Where the world of the sequence would be in the scan.
struct SequenceAlignmentView {
  std::string how;  ///< "pairs", "points" or "objects"
  bool running = true;
  std::string problem;
  Eigen::Isometry3d scan_from_world = Eigen::Isometry3d::Identity();
  Eigen::Vector3d position_std_m{0, 0, 0};  ///< In the middle of what was compared.
  double azimuth_std_rad = 0;
  double turn_rad = 0, shift_m = 0;  ///< From where the project has it; the cameras' mean shift.
  double rmse_m = 0, share = 1;      ///< Of the points or objects that were used.
  struct Residual {
    std::string name;
    double meters = 0;  ///< Negative: it meets nothing.
  };
  std::vector<Residual> residuals;  ///< By objects.
};

/// A part of the scan to be cut out.
struct CropView {
  std::string id;
  bool running = true;
  std::string problem;
  std::shared_ptr<const std::vector<Eigen::Vector3f>> points;  ///< In the scan; null if none.
  Eigen::Vector3d size_m{0, 0, 0};
  int num_faces = 0;                       ///< Of the model; 0 for a fragment.
  std::optional<double> support_height_m;  ///< Of what it stood on, above the floor.
};

/// What a box in the scan holds.
struct BoxView {
  std::shared_ptr<const std::vector<Eigen::Vector3f>> points;  ///< In the scan; never null.
  /// Of those that are not on the floor, in the box's own axes from its centre; may be empty.
  Eigen::AlignedBox3d bounds;
};

/// The answer to a FitBoxCommand.
struct FittedBoxView {
  std::optional<UprightBox> box;  ///< Nothing: none fits.
};

/// Something in the project that is probably wrong, as of AnnotationFinding.
struct FindingView {
  std::string kind, sentence;
  std::vector<std::string> instances;
  bool error = true;        ///< An object is wrong; else it is only worth knowing.
  bool can_accept = false;  ///< It is about placed objects.
  bool accepted = false;    ///< Somebody called it all right, and nothing has changed since.
  std::string accepted_by = {}, accepted_note = {};
};

/// What is probably wrong, as the project is now.
struct ChecklistView {
  std::vector<FindingView> findings;  ///< Errors first, those that were accepted last.
  bool comparing = false;             ///< All objects with their images, ...
  int compared = 0, to_compare = 0;   ///< ... so far, and in all.

  /// That are open.
  int NumErrors() const {
    int errors = 0;
    for (const FindingView& finding : findings) errors += finding.error && !finding.accepted;
    return errors;
  }
  int NumAccepted() const {
    int accepted = 0;
    for (const FindingView& finding : findings) accepted += finding.accepted;
    return accepted;
  }
};

/// One object as two annotators placed it, or one of them alone. Differences are ours minus theirs.
struct AgreedRowView {
  std::string first, second;  ///< Ids, here and there; "": it is not there.
  bool same_model = true;
  bool copied = false;  ///< Both are the same to the last digit, which says nothing.
  double horizontal_m = 0, height_m = 0, tilt_rad = 0;
  std::optional<double> azimuth_rad;  ///< Nothing for what is round.
  std::string second_model;           ///< As the other one has it, and where.
  double second_scale = 1;
  Eigen::Isometry3d second_from = Eigen::Isometry3d::Identity();  ///< scan_from_object
};

/// What another annotator placed.
struct AgreementView {
  std::string name;  ///< Of the file.
  bool running = true;
  std::string problem;
  std::vector<AgreedRowView> rows;
  int pooled = 0;  ///< Objects behind the next two, one annotator's deviations; 0: too few.
  double position_std_m = 0, azimuth_std_rad = 0;
};

/// The last export.
struct ExportView {
  bool running = true;
  std::string problem;  ///< Why nothing was written.
  std::string done;     ///< What was written, and where.
  bool asks = false;    ///< It would replace something else, and waits for an answer.
  std::string out;      ///< What it would replace, ...
  std::vector<std::string> differences;  ///< ... and how that differs.
  /// Errors that are open: nothing was written, and it waits for an answer.
  std::vector<std::string> open_findings;
};

/// What became of a command.
struct CommandOutcome {
  std::uint64_t number = 0;  ///< That AnnotationProcess::Post gave it; 0: there was none.
  std::string refusal;       ///< Why nothing was done; "": it was carried out.
};

/// What crosses to the window.
struct AnnotationSnapshot {
  enum class State { kOpening, kReady, kFailed };
  State state = State::kOpening;
  std::string busy;  ///< What runs now; "": nothing.
  bool can_cancel = false;
  std::string failure;  ///< Why nothing could be opened.

  std::string project_file, project_name, scan_name;
  bool modified = false, read_only = false;
  std::vector<std::string> notices;  ///< What the user should know, until dismissed.
  std::size_t num_recovered = 0;     ///< Edits of a killed process, not yet saved or taken back.
  std::string journal_problem;       ///< Edits are not safe on the disk; "": they are.
  CommandOutcome last_command;       ///< All that were posted before it are done with, too.
  std::string answer;                ///< To the last command: what was refused or done.
  bool refused = false;              ///< The answer is bad news.
  std::uint64_t answer_number = 0;   ///< Counts the answers.
  std::optional<std::string> undo_label, redo_label;
  std::string annotator;
  WorkStage stage = WorkStage::kNew;
  std::optional<ProjectState> project_state;  ///< What people said of it.
  std::optional<AnnotationQueueView> queue;   ///< Once it was asked for.

  /// Made coarse enough to draw, and coarser for machines without a GPU; null until it is read.
  std::shared_ptr<const TriangleMesh> scan, scan_coarse;
  std::size_t scan_points = 0;  ///< Of the file.
  /// What the scan would span if its unit were the metre, where that is more than any room.
  std::optional<double> doubted_size_m;
  bool ready_to_align = false;
  Eigen::Isometry3d level_from_scan = Eigen::Isometry3d::Identity();
  bool floor_known = false, gravity_known = false;
  std::vector<Eigen::Vector3d> cameras_in_scan;  ///< Of the sequence, where there is one.

  /// Never null.
  std::shared_ptr<const std::vector<AnnotationModel>> models =
      std::make_shared<const std::vector<AnnotationModel>>();
  std::uint64_t models_version = 0;
  std::string models_problem;  ///< Why there are none.
  std::vector<AnnotatedInstance> instances;
  int num_fragments = 0;  ///< Parts of the scan that were cut out for VISMA.
  std::string selected;   ///< Id; "": none.

  std::optional<FloorProposal> floor;
  std::optional<PlacementView> placement;
  std::optional<RefinementView> refinement;
  std::optional<SequenceAlignmentView> sequence_alignment;
  std::optional<CropView> crop;
  std::optional<BoxView> box;                       ///< Of the box that is being drawn.
  std::shared_ptr<const FittedBoxView> fitted_box;  ///< Another one for each answer.
  std::optional<ExportView> exported;
  std::optional<AgreementView> agreement;  ///< With another annotator, once that was asked for.
  ChecklistView checklist;
  std::uint64_t proposal_number = 0;  ///< Changes with the five above.

  bool has_sequence = false, sequence_registered = false;
  int num_frames = 0;
  Eigen::Vector2i frame_size{0, 0};  ///< Of the sequence's images.
  std::optional<FrameView> frame;
  std::uint64_t frame_number = 0;  ///< Changes with the image of `frame`.
  std::vector<PairView> pairs;
  /// Of the candidate that is looked at, else of the selected object.
  std::optional<ImageChecksView> checks;
  std::uint64_t images_number = 0;  ///< Changes with the images (not the lines) of `checks`.

  /// Null if there is none of that id.
  const AnnotatedInstance* Find(const std::string& id) const {
    for (const AnnotatedInstance& instance : instances) {
      if (instance.id == id) return &instance;
    }
    return nullptr;
  }
  bool HasProposal() const {
    return floor || placement || refinement || sequence_alignment || crop;
  }
  const AnnotatedInstance* Selected() const { return selected.empty() ? nullptr : Find(selected); }
  const AnnotationModel* Model(int index) const {
    return index < 0 || index >= static_cast<int>(models->size())
               ? nullptr
               : &(*models)[static_cast<std::size_t>(index)];
  }
  /// In `models`; -1: the database has none of that name.
  int ModelIndex(const AnnotatedInstance& instance) const {
    for (std::size_t i = 0; i < models->size(); ++i) {
      if ((*models)[i].name == instance.model) return static_cast<int>(i);
    }
    return -1;
  }
  /// Null if the database has none.
  const AnnotationModel* ModelOf(const AnnotatedInstance& instance) const {
    return Model(ModelIndex(instance));
  }
};

}  // namespace plumbline
