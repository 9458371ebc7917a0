// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <imgui.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/snapshot/annotation_commands.h"
#include "engine/snapshot/annotation_snapshot.h"
#include "ui/files/saved_view.h"
#include "ui/framework/scene_surface.h"
#include "ui/framework/sight_line.h"

namespace plumbline {

/// What a click in the 3-D view of the Annotate workspace does.
enum class AnnotateTool { kSelect, kFloor, kPlace, kSequence, kCut };

/// A pose on its way: shown, but not yet an edit.
struct PendingPose {
  std::string id;
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
  std::optional<std::uint64_t> command;  ///< Number of the one that makes it an edit, once posted.
  std::vector<InstancePose> and_also = {};  ///< Of what moves along.

  /// Where an instance is on its way to; null for those that stay.
  const Eigen::Isometry3d* Find(const std::string& instance) const {
    if (instance == id) return &scan_from_object;
    for (const InstancePose& other : and_also)
      if (other.id == instance) return &other.scan_from_object;
    return nullptr;
  }
};

/// A box that stands upright in the level frame, for cutting out what is in it.
struct LevelBox {
  Eigen::Vector3d center{0, 0, 0};
  Eigen::Vector3d size_m{0.7, 0.7, 1};  ///< Along its own axes.
  double azimuth_rad = 0;               ///< Of its x axis.

  bool operator==(const LevelBox&) const = default;
};

/// A model that would land where the mouse is.
struct GhostModel {
  int model = -1;
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
};

/// What the panels of the Annotate workspace share, besides the snapshot.
struct AnnotateView {
  AnnotateTool tool = AnnotateTool::kSelect;
  std::string model;     ///< The one that is to be placed.
  int candidate = 0;     ///< Of the placement that is shown.
  bool on_floor = true;  ///< What stands on the floor stays on it.
  bool scan = true, models = true, grid = true, cameras = false;
  bool masks = false;  ///< The masks of a frame stand in the place of the images.
  ScanLook scan_look;
  std::vector<SavedView> saved_views;
  std::string view_name;  ///< That is being typed, for the next one.
  std::optional<PendingPose> pending;
  bool nudged = false;                          ///< `pending` comes from keys that are still held.
  std::optional<Eigen::Isometry3d> copied;      ///< Pose in the scan's frame, ...
  std::string copied_id;                        ///< ... and of which object.
  std::optional<Eigen::Vector3d> pick_in_scan;  ///< Half a pair: the frame's half is missing, ...
  std::optional<Eigen::Vector2d> pick_pixel;    ///< ... or the scan's. Of the frame that is shown.
  bool crop_by_line = false;                    ///< Else by a box.
  std::optional<LevelBox> crop_box;
  std::vector<Eigen::Vector2d> lasso;  ///< Corners in the view [px] of what is cut out.
  bool lasso_closed = false;
  Eigen::Vector2d view_px{1, 1};  ///< Size of the 3-D view.
  std::string crop_id = "cutout", crop_category = "object";
  bool crop_fragment = false;
  std::string map_points, mapped_run;        ///< Paths that are being typed.
  std::string save_as, run, save_elsewhere;  ///< Likewise.
  std::size_t export_format = 0;             ///< In kExportFormats.
  std::string export_frame = "scan", export_out;
  int export_every = 1;
  std::vector<std::string> also_selected;    ///< Besides the snapshot's: ids, for the list.
  bool check = false;                        ///< The list of findings instead of the objects.
  int finding = -1;                          ///< The last one that was looked at.
  bool accept_finding = false;               ///< In this frame: it is asked why it is all right.
  std::string second;                        ///< Another's project: a path that is being typed.
  int agreed_row = -1;                       ///< Of the agreement, which is shown in the scene.
  std::string finding_note;                  ///< Why, as it is being typed.
  std::string focus_on;                      ///< The view turns to it as soon as it is selected.
  bool focus = false;                        ///< In this frame: the view turns to the selection.
  std::optional<Eigen::Vector3d> look_from;  ///< In this frame: the view looks at the selection
                                             ///< from this point of the scan.
  bool reset = false;                        ///< In this frame: the view shows everything.
  bool open_export = false, open_more = false,
       open_queue = false;               ///< In this frame: the sheet opens.
  std::string queue_folder, stage_note;  ///< That are being typed.
  bool boxing = false;  ///< The next drag in the 3-D view selects what it encloses.
  std::vector<std::string> select_also;  ///< Besides the first of them, which is being selected.
  bool select_copies = false;            ///< What is added by the next edit is selected together.
  bool awaits_box = false;               ///< The box that fits what was clicked is being found.
};

/// What the 3-D view of the Annotate workspace shows.
struct AnnotateContent {
  std::shared_ptr<const AnnotationSnapshot> snapshot;
  std::uint64_t version = 0;  ///< Changes with `snapshot`.
  std::optional<PendingPose> pending;
  std::optional<GhostModel> ghost;
  int candidate = 0;
  bool scan = true, models = true, grid = true, cameras = false;
  bool light = false;
  ScanLook scan_look;
  int agreed_row = -1;  ///< Of the agreement: where the other one has it, as a white outline.
  std::vector<std::string> also_selected;
};

/// The 3-D view of the Annotate workspace as the panels know it; ui/scene implements it. It shows
/// the level frame. Pixels count from the top left of the view.
class AnnotateSurface {
 public:
  virtual ~AnnotateSurface() = default;
  virtual void SetContent(const AnnotateContent& content) = 0;
  virtual ImTextureID Texture(int width, int height, bool interacting) = 0;
  virtual void Orbit(double dx_px, double dy_px) = 0;
  virtual void Pan(double dx_px, double dy_px) = 0;
  virtual void Zoom(double notches) = 0;
  virtual void FocusAt(double x_px, double y_px) = 0;
  virtual void FocusOn(const std::string& instance) = 0;
  /// Looks at it from a point of the level frame.
  virtual void LookAtFrom(const std::string& instance, const Eigen::Vector3d& eye_in_level) = 0;
  virtual void Reset() = 0;
  virtual void SetDirection(double azimuth_rad, double elevation_rad) = 0;
  /// Focus, direction and distance.
  virtual void SetCamera(const SceneCamera& camera) = 0;
  /// Id of the instance under a pixel; "" if there is none.
  virtual std::string PickInstance(double x_px, double y_px) = 0;
  /// The point of the scan under a pixel, in the level frame.
  virtual std::optional<Eigen::Vector3d> PickScan(double x_px, double y_px) = 0;
  /// In the level frame (z up, floor at 0).
  virtual SightLine Sight(double x_px, double y_px) const = 0;
  /// Pixel of a point of the level frame; nothing behind the eye.
  virtual std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& in_level) const = 0;
  virtual SceneCamera camera() const = 0;
  virtual double last_render_ms() const = 0;
  virtual int renders() const = 0;
  virtual double grid_step_m() const = 0;
};

}  // namespace plumbline
