// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <imgui.h>
#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/snapshot/commands.h"
#include "engine/snapshot/comparison_view.h"
#include "engine/snapshot/fork_view.h"
#include "engine/snapshot/frame_analysis.h"
#include "engine/snapshot/graph_view.h"
#include "engine/snapshot/networks_view.h"
#include "engine/snapshot/object_history.h"
#include "engine/snapshot/object_look.h"
#include "engine/snapshot/playback_view.h"
#include "engine/snapshot/probe_view.h"
#include "engine/snapshot/sequence_view.h"
#include "engine/snapshot/timing_statistics.h"
#include "ui/files/bookmark_file.h"
#include "ui/framework/theme.h"

namespace plumbline {

class AnnotateSurface;
class PathDialog;
class SceneSurface;
struct AnnotateView;
struct AnnotationSnapshot;
struct MapSnapshot;
struct ObjectReport;
struct TruthsView;

/// Pictures on their way to the screen. The GL implementation is in gl_texture_store.h; tests use a
/// null one.
class TextureStore {
 public:
  virtual ~TextureStore() = default;
  /// The texture `name`; calls `make` (CV_8UC3 BGR) only if `version` differs from that of the last
  /// call.
  virtual ImTextureID Get(std::string_view name, std::uint64_t version,
                          const std::function<cv::Mat()>& make) = 0;
};

/// Where every named widget was drawn in this frame: scripts and tests find them by name.
class WidgetLog {
 public:
  struct Rect {
    ImVec2 low, high;
  };
  void Clear() { rects_.clear(); }
  void Add(std::string name, ImVec2 low, ImVec2 high) {
    rects_.insert_or_assign(std::move(name), Rect{low, high});
  }
  const Rect* Find(const std::string& name) const {
    const auto found = rects_.find(name);
    return found == rects_.end() ? nullptr : &found->second;
  }
  const std::map<std::string, Rect>& rects() const { return rects_; }

 private:
  std::map<std::string, Rect> rects_;
};

/// Which part of the image the image views show; they share one, so that they stay side by side.
struct ImageViewport {
  float zoom = 1;             ///< 1: the whole image fits.
  ImVec2 center{0.5f, 0.5f};  ///< Share of the image's width and height.
};

struct Selection {
  ObjectId object;     ///< Not valid: none.
  int particle = -1;   ///< Of that object; -1: none.
  int hypothesis = 0;  ///< Of the probe: its contour is drawn.
  int hovered = -1;    ///< The particle under the mouse.
  std::string truth;   ///< A true instance instead of an object, by its id; "": none.
};

/// A second run of the same sequence, on the clock of the first.
struct OtherRun {
  std::string source;                                ///< Its file.
  std::shared_ptr<const SequenceView> sequence;      ///< Null until it is open.
  std::shared_ptr<const MapSnapshot> snapshot;       ///< Null until its first frame.
  std::shared_ptr<const PlaybackView> playback;      ///< Never null.
  std::shared_ptr<const ObjectLooks> looks;          ///< Null until its first frame.
  std::uint64_t version = 0;                         ///< Changes with `snapshot`.
  std::shared_ptr<const ComparisonView> comparison;  ///< Null until it is worked out.
};

/// Another run that could be made of what is open.
struct ForkOffer {
  std::string why_not;    ///< Why what is open cannot be forked; "": it can.
  MapperOptions options;  ///< Those of the run.
  std::uint64_t seed = 0;
  std::string out;  ///< A name for the new file that is free.
};

/// What one frame of the window shows. All panels of a frame see the same.
struct FrameContext {
  std::shared_ptr<const SequenceView> sequence;       ///< Null until it is open.
  std::shared_ptr<const MapSnapshot> snapshot;        ///< Null until the first frame.
  std::shared_ptr<const PlaybackView> playback;       ///< Never null.
  std::shared_ptr<const MapSnapshot> first_snapshot;  ///< Of what is open, whichever run shows.
  std::shared_ptr<const OtherRun> other;              ///< Null: no second run.
  RunShown run_shown = RunShown::kFirst;
  bool shows_other = false;                      ///< `snapshot` is that of the other run.
  std::shared_ptr<const ForkOffer> fork_offer;   ///< Null: nothing is open.
  std::shared_ptr<const ForkView> fork;          ///< The last one; null: none yet.
  std::shared_ptr<const NetworksView> networks;  ///< Null until it is known.
  std::shared_ptr<const GraphView> graph;        ///< That maps what is open; null: none is told.
  /// Of the run that is to take the place of what is open, once it is open or has failed to; null:
  /// none.
  std::shared_ptr<const PlaybackView> reopening;
  std::shared_ptr<const ProbeView> probe;  ///< The last answer, maybe of another frame; null: none.
  std::shared_ptr<const FrameAnalysis> analysis;  ///< Of `snapshot`; null until it is known.
  std::shared_ptr<const ObjectHistory> history;   ///< Of the object watched last; null: of none.
  std::shared_ptr<const TruthsView> truths;       ///< Null without ground truth.
  /// Of the stages over all frames; null unless a panel needed them.
  std::shared_ptr<const TimingStatistics> timings;
  std::shared_ptr<const ObjectLooks> looks;        ///< Of the run that shows; null: none yet.
  std::shared_ptr<const ObjectLooks> first_looks;  ///< Of what is open, whichever run shows.
  std::uint64_t looks_version = 0;                 ///< Changes with `looks`.
  std::uint64_t snapshot_version = 0;              ///< Changes with `snapshot`.
  std::string source;                ///< What was opened, as it was named; "": nothing.
  bool lacks_poses = false;          ///< Why it could not be opened: no frame has a pose.
  bool has_imu = false;              ///< It does have an IMU then.
  std::uint64_t source_version = 0;  ///< Changes when something else is opened.
  std::vector<Bookmark> bookmarks;   ///< Of what is open, by frame.
  bool ask_frame = false;            ///< In this frame: the keyboard goes to the field for it.
  std::vector<std::string> recent;   ///< What was opened before, newest first.
  Selection selection;
  bool follow = false;                   ///< The 3-D view moves with the camera.
  bool look_through = false;             ///< The 3-D view is that of the camera.
  bool light = false;                    ///< Theme
  bool help_shown = false;               ///< The help sheet lies over the panels.
  int image_views = 5;                   ///< How many there are.
  bool confirmed_only = false;           ///< Views leave out what is not confirmed (Shows).
  std::string maximized;                 ///< The panel that fills the workspace; "": none.
  std::set<std::string> hidden_panels;   ///< By id.
  std::vector<std::string> own_layouts;  ///< Names.
  bool presenting = false;               ///< Full screen with captions; panels show no controls.
  bool bare = false;                     ///< A figure: panels without their controls.
  double window_ms = 0;                  ///< CPU time of drawing the last window frame.
  double scene_ms = 0;                   ///< Of the last render of the 3-D view.
  double ui_scale = 1;
  std::string renderer;  ///< GL_RENDERER
  WorkspaceId workspace = WorkspaceId::kInspect;
  std::shared_ptr<const AnnotationSnapshot> annotation;  ///< Null: no scan is open.
  std::uint64_t annotation_version = 0;                  ///< Changes with `annotation`.
  Fonts fonts;

  // What panels draw with.
  TextureStore* textures = nullptr;
  WidgetLog* widgets = nullptr;
  ImageViewport* viewport = nullptr;
  SceneSurface* scene = nullptr;
  AnnotateView* annotate = nullptr;
  AnnotateSurface* annotate_scene = nullptr;
  PathDialog* path_dialog = nullptr;  ///< Through AskPath().

  /// Of the run that shows.
  const PlaybackView& shown_playback() const {
    return shows_other && other != nullptr ? *other->playback : *playback;
  }
  /// Null if nothing is selected or it does not live in this frame.
  const ObjectReport* SelectedObject() const;
  /// Of the selected object's particles in this frame, the best first; null until it is known.
  const std::vector<int>* ParticlesByRank() const;
  /// Of an object of this frame; null until it is known.
  const ObjectSpread* SpreadOf(ObjectId object) const;
  /// Null for a label that the sequence has no model for.
  const ModelView* Model(ModelId id) const {
    if (sequence == nullptr || id.value < 0) return nullptr;
    const auto index = static_cast<std::size_t>(id.value);
    return index < sequence->models.size() ? &sequence->models[index] : nullptr;
  }
  ObjectLook LookOf(ObjectId id) const { return LookOf(looks.get(), id); }
  /// In either of two runs.
  static ObjectLook LookOf(const ObjectLooks* run, ObjectId id);
  /// Whether views draw an object: not if it is unconfirmed and only confirmed ones are asked for.
  bool Shows(const ObjectReport& object) const;
  ImU32 ColorOf(ObjectId id) const { return ColorOfLook(LookOf(id)); }
  float Scaled(double pixels) const { return static_cast<float>(pixels * ui_scale); }
};

}  // namespace plumbline
