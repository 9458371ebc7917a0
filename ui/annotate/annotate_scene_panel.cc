// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/annotate/annotate_actions.h"
#include "ui/annotate/annotate_crop_box.h"
#include "ui/annotate/annotate_edits.h"
#include "ui/annotate/annotate_gizmo.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_view_menu.h"
#include "ui/common/scene_mouse.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr ImGuiButtonFlags kAllButtons = ImGuiButtonFlags_MouseButtonLeft |
                                         ImGuiButtonFlags_MouseButtonRight |
                                         ImGuiButtonFlags_MouseButtonMiddle;

struct LayerToggle {
  const char* name;
  const char* label;
  bool AnnotateView::*layer;
  const char* tooltip;
};
constexpr LayerToggle kLayers[] = {
    {"scan", "Scan", &AnnotateView::scan, "The scan."},
    {"models", "Models", &AnnotateView::models, "The models that are placed."},
    {"grid", "Grid", &AnnotateView::grid, "Grid at height 0: the floor, once it is known."},
    {"cameras", "Path", &AnnotateView::cameras, "Where the cameras of the sequence were."},
};

constexpr const char* kViewMenu = "View";

class AnnotateScenePanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink& sink) override {
    AnnotateView& view = *context.annotate;
    const auto tool = [&](AnnotateTool which, const char* name, const char* label,
                          const char* help) {
      bool on = view.tool == which;
      if (Toggle(context, name, label, on, help)) {
        view.tool = on ? which : AnnotateTool::kSelect;
        sink.Post(CancelProposalCommand{});
      }
      ImGui::SameLine();
    };
    tool(AnnotateTool::kSelect, "annotate.tool.select", "Select",
         "A click selects an object (Esc comes back here).");
    tool(AnnotateTool::kFloor, "annotate.tool.floor", "Floor",
         "A click on the floor finds the whole floor, and with it the direction of gravity.");
    // They stay where they are, whatever can be done now.
    ImGui::BeginDisabled(view.model.empty());
    tool(AnnotateTool::kPlace, "annotate.tool.place", "Place",
         "A click puts the chosen model there. M, or a click on a model, chooses one.");
    ImGui::EndDisabled();
    ImGui::BeginDisabled(!context.annotation->has_sequence);
    tool(AnnotateTool::kSequence, "annotate.tool.sequence", "Sequence",
         "Where the sequence is in the scan: register it by pairs of points, by the points of "
         "its map or by its objects.");
    ImGui::EndDisabled();
    tool(AnnotateTool::kCut, "annotate.tool.cut", "Cut out",
         "An object of the scan becomes a model of the database or a VISMA fragment.");
    float width = 0;
    for (const LayerToggle& layer : kLayers) {
      width += ToggleWidth(context, layer.label) + context.Scaled(3);
    }
    width += ToggleWidth(context, kViewMenu) + context.Scaled(3);
    AlignRight(width);
    for (const LayerToggle& layer : kLayers) {
      Toggle(context, std::string("annotate.layer.") + layer.name, layer.label, view.*layer.layer,
             layer.tooltip);
      ImGui::SameLine();
    }
    bool open = false;
    if (Toggle(context, "annotate.looks", kViewMenu, open,
               "Colours and points of the scan; views to come back to."))
      ImGui::OpenPopup("annotate.looks");
    if (ImGui::BeginPopup("annotate.looks")) {
      DrawViewMenu(context);
      if (ImGui::IsKeyReleased(keys::kEscape)) ImGui::CloseCurrentPopup();
      ImGui::EndPopup();
    }
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    AnnotateView& view = *context.annotate;
    if (context.annotate_scene == nullptr) {
      return EmptyState(context, "No 3-D view", "This display has no OpenGL that VTK can use.");
    }
    AnnotateSurface& scene = *context.annotate_scene;
    scene.SetContent({context.annotation, context.annotation_version, view.pending, ghost_,
                      view.candidate, view.scan, view.models, view.grid, view.cameras,
                      context.light, view.scan_look, view.agreed_row, view.also_selected});
    if (!view.focus_on.empty() && context.annotation->selected == view.focus_on) {
      view.focus = true;
      view.focus_on.clear();
    }
    if (view.focus) scene.FocusOn(context.annotation->selected);
    if (view.reset) scene.Reset();
    if (view.look_from) {
      scene.LookAtFrom(context.annotation->selected,
                       context.annotation->level_from_scan * *view.look_from);
    }
    view.focus = view.reset = false;
    view.look_from.reset();
    const ImVec2 low = ImGui::GetCursorScreenPos();
    const ImVec2 size = ImGui::GetContentRegionAvail();
    const int width = std::max(8, static_cast<int>(size.x)),
              height = std::max(8, static_cast<int>(size.y));
    const ImVec2 high(low.x + static_cast<float>(width), low.y + static_cast<float>(height));
    ImGui::InvisibleButton("annotate.view", {static_cast<float>(width), static_cast<float>(height)},
                           kAllButtons);
    ImGui::SetItemAllowOverlap();
    LogItem(context, "annotate.view");
    const bool held = gizmo_.Handle(context, low, sink) || crop_box_.Handle(context, low);
    view.view_px = {static_cast<double>(width), static_cast<double>(height)};
    const bool lassoes = view.tool == AnnotateTool::kCut && view.crop_by_line;
    const bool boxes = view.boxing && view.tool == AnnotateTool::kSelect;
    const bool moving = MoveView(scene, low, held || lassoes || boxes);
    if (const auto at = ClickedAt(); at && !held)
      Click(context, {at->x - low.x, at->y - low.y}, sink);
    if (const auto at = ClickedAt(ImGuiMouseButton_Right)) {
      const std::string id = scene.PickInstance(at->x - low.x, at->y - low.y);
      const std::vector<std::string> selected = SelectedInstances(context);
      const bool among = std::find(selected.begin(), selected.end(), id) != selected.end();
      if (!id.empty() && !among) SelectInstances(context, {id}, sink);
      ImGui::OpenPopup("annotate.menu");
    }
    const auto box = lassoes || boxes ? DragBox(context, low, sink) : std::nullopt;
    ShowBox(context, sink);
    ForgetLasso(context);
    const bool hovers = MoveGhost(context, low);
    const ImTextureID texture = scene.Texture(width, height, moving || held || hovers);
    ImGui::GetWindowDrawList()->AddImageRounded(texture, low, high, {0, 1}, {1, 0}, IM_COL32_WHITE,
                                                context.Scaled(4));
    gizmo_.Draw(context, low, high);
    crop_box_.Draw(context, low, high);
    DrawTriad(context, scene.camera().view_from_world, low, high);
    DrawPicks(context, low, high);
    DrawLasso(context, low, box);
    DrawLabels(context, low, high);
    DrawAnnotateBanners(context, low, high, sink);
    if (ImGui::BeginPopup("annotate.menu")) {
      DrawAnnotateMenu(context, actions_, sink);
      // As it goes up: while it goes down the menu is open, and the key does nothing else.
      if (ImGui::IsKeyReleased(keys::kEscape)) ImGui::CloseCurrentPopup();
      ImGui::EndPopup();
    }
  }

 private:
  using Ids = std::vector<std::string>;

  static bool Adds() { return ImGui::GetIO().KeyCtrl || ImGui::GetIO().KeyShift; }

  /// Those whose middle shows inside the box.
  static void SelectInBox(const FrameContext& context, const Eigen::AlignedBox2d& box,
                          CommandSink& sink) {
    const AnnotationSnapshot& snapshot = *context.annotation;
    Ids ids = Adds() ? SelectedInstances(context) : Ids{};
    for (const AnnotatedInstance& instance : snapshot.instances) {
      const AnnotationModel* model = snapshot.ModelOf(instance);
      if (instance.hidden || model == nullptr) continue;
      const auto seen =
          context.annotate_scene->Project(snapshot.level_from_scan * instance.scan_from_object *
                                          model->bounds.center().cast<double>());
      if (!seen || !box.contains(*seen)) continue;
      if (std::find(ids.begin(), ids.end(), instance.id) == ids.end()) ids.push_back(instance.id);
    }
    context.annotate->boxing = false;
    SelectInstances(context, std::move(ids), sink);
  }

  static void Click(const FrameContext& context, ImVec2 at, CommandSink& sink) {
    AnnotateView& view = *context.annotate;
    AnnotateSurface& scene = *context.annotate_scene;
    const double x = at.x, y = at.y;
    if (view.tool == AnnotateTool::kSelect) {
      const std::string id = scene.PickInstance(x, y);
      const bool one_more = Adds() && context.annotation->Selected() != nullptr;
      view.boxing = false;
      if (!one_more) return SelectInstances(context, id.empty() ? Ids{} : Ids{id}, sink);
      if (!id.empty()) ToggleSelected(context, id, sink);
      return;
    }
    const bool cuts = view.tool == AnnotateTool::kCut;
    if (cuts && view.crop_by_line) return AddCorner(context, {x, y}, sink);
    if (view.tool == AnnotateTool::kPlace) return PlaceChosenModel(context, x, y, sink);
    const auto point = scene.PickScan(x, y);
    if (!point) return;
    if (cuts) return PutBox(context, *point, sink);
    const Eigen::Vector3d in_scan = context.annotation->level_from_scan.inverse() * *point;
    if (view.tool == AnnotateTool::kFloor) {
      sink.Post(FindFloorCommand{in_scan});
    } else {
      Pick(context, in_scan, sink);
    }
  }

  static void Pick(const FrameContext& context, const Eigen::Vector3d& in_scan, CommandSink& sink) {
    AnnotateView& view = *context.annotate;
    if (view.pick_pixel && context.annotation->frame) {
      sink.Post(AddPairCommand{in_scan, context.annotation->frame->frame, *view.pick_pixel});
      view.pick_in_scan.reset();
      view.pick_pixel.reset();
    } else {
      view.pick_in_scan = in_scan;
    }
  }

  /// Around what was clicked, from the floor up if that is known, until one that fits it is found;
  /// one that is there stays.
  static void PutBox(const FrameContext& context, const Eigen::Vector3d& point, CommandSink& sink) {
    constexpr double kAround_m = 0.3, kFloorMargin_m = 0.05;
    AnnotateView& view = *context.annotate;
    if (view.crop_box) return;
    LevelBox box;
    const bool floor = context.annotation->floor_known && point.z() > -kAround_m;
    const double bottom = floor ? -kFloorMargin_m : point.z() - kAround_m;
    const double top = point.z() + kAround_m;
    box.center = {point.x(), point.y(), 0.5 * (bottom + top)};
    box.size_m.z() = top - bottom;
    view.crop_box = box;
    view.awaits_box = true;
    sink.Post(FitBoxCommand{context.annotation->level_from_scan.inverse() * point,
                            context.annotate_scene->camera().azimuth_rad});
  }

  /// Has the engine say what is in the box, whenever it changed; a cut of another box is dropped.
  void ShowBox(const FrameContext& context, CommandSink& sink) {
    AnnotateView& view = *context.annotate;
    if (view.tool != AnnotateTool::kCut || view.crop_by_line) view.crop_box.reset();
    if (view.crop_box == shown_box_) return;
    shown_box_ = view.crop_box;
    if (!shown_box_) return sink.Post(ShowBoxCommand{});
    sink.Post(ShowBoxCommand{InScan(*context.annotation, *shown_box_)});
    if (context.annotation->crop) sink.Post(CancelProposalCommand{});
  }

  /// A click: another corner of the line, or the first one again to close it.
  static void AddCorner(const FrameContext& context, const Eigen::Vector2d& at, CommandSink& sink) {
    AnnotateView& view = *context.annotate;
    if (view.lasso_closed) {
      view.lasso.clear();
      view.lasso_closed = false;
      sink.Post(CancelProposalCommand{});
    }
    if (view.lasso.size() > 2 && (view.lasso.front() - at).norm() < context.Scaled(8)) {
      return ProposeCrop(context, sink);
    }
    view.lasso.push_back(at);
  }

  /// The box that is being dragged, in pixels of the view; when the button is let go, what is in it
  /// is selected or proposed to be cut out.
  static std::optional<Eigen::AlignedBox2d> DragBox(const FrameContext& context, ImVec2 low,
                                                    CommandSink& sink) {
    const ImGuiIO& io = ImGui::GetIO();
    const ImVec2 from = io.MouseClickedPos[ImGuiMouseButton_Left];
    Eigen::AlignedBox2d box;
    for (const ImVec2& corner : {from, io.MousePos}) {
      box.extend(Eigen::Vector2d(corner.x - low.x, corner.y - low.y));
    }
    if (box.sizes().minCoeff() < 4) return std::nullopt;
    if (ImGui::IsItemActive() && ImGui::IsMouseDown(ImGuiMouseButton_Left)) return box;
    if (!ImGui::IsItemDeactivated() || !ImGui::IsMouseReleased(ImGuiMouseButton_Left)) {
      return std::nullopt;
    }
    AnnotateView& view = *context.annotate;
    if (view.tool == AnnotateTool::kSelect) {
      SelectInBox(context, box, sink);
      return std::nullopt;
    }
    const Eigen::Vector2d a = box.min(), b = box.max();
    view.lasso = {a, {b.x(), a.y()}, b, {a.x(), b.y()}};
    ProposeCrop(context, sink);
    return std::nullopt;
  }

  /// The line belongs to the view in which it was drawn.
  void ForgetLasso(const FrameContext& context) {
    AnnotateView& view = *context.annotate;
    Eigen::Matrix<double, 3, 5> now;
    now << context.annotate_scene->camera().view_from_world,
        context.annotate_scene->Sight(0, 0).eye,
        Eigen::Vector3d(view.view_px.x(), view.view_px.y(), 0);
    if (now == lasso_view_ && view.tool == AnnotateTool::kCut) return;
    lasso_view_ = now;
    view.lasso.clear();
    view.lasso_closed = false;
  }

  static void DrawLasso(const FrameContext& context, ImVec2 low,
                        const std::optional<Eigen::AlignedBox2d>& box) {
    const AnnotateView& view = *context.annotate;
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const auto at = [&](const Eigen::Vector2d& p) {
      return ImVec2(low.x + static_cast<float>(p.x()), low.y + static_cast<float>(p.y()));
    };
    if (box) {
      draw.AddRectFilled(at(box->min()), at(box->max()), WithAlpha(colors::kAccent, 0.15));
      draw.AddRect(at(box->min()), at(box->max()), colors::kAccent);
    }
    std::vector<ImVec2> points;
    for (const Eigen::Vector2d& corner : view.lasso) points.push_back(at(corner));
    draw.AddPolyline(points.data(), static_cast<int>(points.size()), colors::kAccent,
                     view.lasso_closed ? ImDrawFlags_Closed : 0, context.Scaled(1.5f));
    if (view.lasso_closed) return;
    for (const ImVec2& point : points) {
      draw.AddCircleFilled(point, context.Scaled(3), colors::kAccent);
    }
  }

  static void DrawPicks(const FrameContext& context, ImVec2 low, ImVec2 high) {
    const AnnotateView& view = *context.annotate;
    if (view.tool != AnnotateTool::kSequence) return;
    PictureLabels labels(context, low, high);
    const auto mark = [&](const Eigen::Vector3d& in_scan, ImU32 color, const std::string& text) {
      const auto seen =
          context.annotate_scene->Project(context.annotation->level_from_scan * in_scan);
      if (!seen) return;
      const ImVec2 at(low.x + static_cast<float>(seen->x()), low.y + static_cast<float>(seen->y()));
      ImDrawList& draw = *ImGui::GetWindowDrawList();
      draw.AddCircleFilled(at, context.Scaled(4), color);
      draw.AddCircle(at, context.Scaled(5), IM_COL32(0, 0, 0, 160));
      if (!text.empty()) {
        labels.Add({{at.x + context.Scaled(6), at.y - context.Scaled(4)}}, colors::kOnPicture,
                   text);
      }
    };
    int number = 0;
    for (const PairView& pair : context.annotation->pairs) {
      mark(pair.in_scan, IM_COL32(120, 255, 160, 255), fmt::format("{}", ++number));
    }
    if (view.pick_in_scan) mark(*view.pick_in_scan, colors::kAccent, "");
  }

  /// Keeps the model that is to be placed under the mouse; true while it moves.
  bool MoveGhost(const FrameContext& context, ImVec2 low) {
    const AnnotateView& view = *context.annotate;
    const AnnotationSnapshot& snapshot = *context.annotation;
    const bool places =
        view.tool == AnnotateTool::kPlace && !snapshot.placement && ImGui::IsItemHovered();
    if (!places) {
      ghost_.reset();
      return false;
    }
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (mouse.x == ghost_at_.x && mouse.y == ghost_at_.y) return false;
    ghost_at_ = mouse;
    ghost_.reset();
    const auto point = PlaceAt(context, mouse.x - low.x, mouse.y - low.y);
    for (int i = 0; point && i < static_cast<int>(snapshot.models->size()); ++i) {
      const AnnotationModel& model = *snapshot.Model(i);
      if (model.name != view.model) continue;
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.translation() = *point;
      if (view.on_floor && model.on_floor && snapshot.floor_known) pose.translation().z() = 0;
      ghost_ = GhostModel{i, snapshot.level_from_scan.inverse() * pose};
    }
    return true;
  }

  /// What the next click does, over the picture.
  static std::string Hint(const FrameContext& context) {
    const AnnotateView& view = *context.annotate;
    const AnnotationSnapshot& snapshot = *context.annotation;
    if (snapshot.scan == nullptr) return snapshot.busy.empty() ? "" : snapshot.busy + " ...";
    if (snapshot.placement && snapshot.placement->running) return "Trying 24 azimuths ...";
    if (snapshot.placement) return "Choose a candidate: Enter accepts it, Esc discards it.";
    if (snapshot.floor) return "Is this the floor? Enter accepts it, Esc discards it.";
    if (view.tool == AnnotateTool::kFloor) return "Click on the floor.";
    if (snapshot.crop) return "Is this the object? Enter accepts it, Esc discards it.";
    if (view.tool == AnnotateTool::kCut && !view.crop_by_line) {
      return view.crop_box ? "Fit the box around the object; Enter cuts it out."
                           : "Click the object to cut out.";
    }
    if (view.tool == AnnotateTool::kCut) {
      return view.lasso.empty() ? "Drag a box around the object, or click corners around it."
                                : "Click the next corner; Enter closes the line.";
    }
    if (view.boxing && view.tool == AnnotateTool::kSelect)
      return "Drag a box around objects (Shift: adds them). Esc leaves it.";
    if (snapshot.sequence_alignment) return "Is the path right? Enter accepts it, Esc discards it.";
    if (view.tool == AnnotateTool::kSequence) {
      return view.pick_in_scan ? "Now click the same point in the frame below."
             : view.pick_pixel ? "Now click the same point here."
                               : "Click a point that you know again in a frame.";
    }
    if (view.tool == AnnotateTool::kPlace) {
      return "Click where the " + view.model + " stands (Enter: here in the middle). Esc stops.";
    }
    return "";
  }

  static void DrawLabels(const FrameContext& context, ImVec2 low, ImVec2 high) {
    PictureLabels labels(context, low, high);
    const std::string grid = fmt::format("grid {:g} m", context.annotate_scene->grid_step_m());
    const float margin = context.Scaled(6);
    if (context.annotate->grid) {
      labels.Add({{high.x - labels.SizeOf(grid).x - margin, high.y - margin}},
                 colors::kOnPictureDim, grid);
    }
    const std::string hint = Hint(context);
    if (hint.empty()) return;
    labels.Add({{0.5f * (low.x + high.x - labels.SizeOf(hint).x), high.y - margin}},
               colors::kOnPicture, hint);
  }

  std::vector<ActionGroup> actions_ = AnnotateActions();
  AnnotateGizmo gizmo_;
  CropBoxHandles crop_box_;
  std::optional<LevelBox> shown_box_;
  Eigen::Matrix<double, 3, 5> lasso_view_ = Eigen::Matrix<double, 3, 5>::Zero();
  std::optional<GhostModel> ghost_;
  ImVec2 ghost_at_{-1, -1};
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateScenePanel() { return std::make_unique<AnnotateScenePanel>(); }

}  // namespace plumbline
