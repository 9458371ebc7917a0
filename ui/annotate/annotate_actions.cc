// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_actions.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "ui/annotate/annotate_agreement.h"
#include "ui/annotate/annotate_edits.h"
#include "ui/annotate/annotate_findings.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/framework/annotate_view.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

// labelCloud's keys for moving, with finer steps; Shift is coarse.
constexpr double kFine_m = 0.005, kCoarse_m = 0.05;
constexpr double kFine_rad = 0.5 * std::numbers::pi / 180, kCoarse_rad = 5 * std::numbers::pi / 180;

/// One of the six floor directions and turns, for each nudge key.
struct Nudge {
  int key;
  double right, ahead, up, turn;
};
constexpr Nudge kNudges[] = {{keys::kW, 0, 1, 0, 0},  {keys::kS, 0, -1, 0, 0},
                             {keys::kA, -1, 0, 0, 0}, {keys::kD, 1, 0, 0, 0},
                             {keys::kE, 0, 0, 1, 0},  {keys::kQ, 0, 0, -1, 0},
                             {keys::kZ, 0, 0, 0, 1},  {keys::kX, 0, 0, 0, -1}};

bool Editable(const FrameContext& context, const AnnotatedInstance* instance) {
  return instance != nullptr && !instance->locked && !context.annotation->read_only;
}

/// What the nudge keys of this frame ask for, as the view is turned: metres in the level frame, and
/// a turn. True while one of them is down.
bool ReadNudges(const FrameContext& context,
                const std::function<void(const Vector3d& by, double turn_rad)>& nudge_by) {
  const ImGuiIO& io = ImGui::GetIO();
  const Eigen::Matrix3d eye = context.annotate_scene->camera().view_from_world;
  Vector3d right = eye.row(0).transpose();
  right.z() = 0;
  right.normalize();
  const Vector3d ahead = Vector3d::UnitZ().cross(right);
  bool any_down = false;
  for (const Nudge& nudge : kNudges) {
    any_down = any_down || ImGui::IsKeyDown(nudge.key);
    if (io.KeyCtrl || !ImGui::IsKeyPressed(nudge.key, true)) continue;
    const double step = io.KeyShift ? kCoarse_m : kFine_m;
    nudge_by(step * (nudge.right * right + nudge.ahead * ahead + nudge.up * Vector3d::UnitZ()),
             nudge.turn * (io.KeyShift ? kCoarse_rad : kFine_rad));
  }
  return any_down;
}

void NudgeBox(const FrameContext& context, LevelBox& box) {
  ReadNudges(context, [&](const Vector3d& by, double turn_rad) {
    box.center += by;
    box.azimuth_rad = WrapAngle(box.azimuth_rad + turn_rad);
  });
}

void PostNudges(const FrameContext& context, const AnnotatedInstance& instance, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  AnnotateView& view = *context.annotate;
  const bool any_down = ReadNudges(context, [&](const Vector3d& by, double turn_rad) {
    const bool moving = view.pending && view.pending->id == instance.id;
    Eigen::Isometry3d pose = moving ? view.pending->scan_from_object : instance.scan_from_object;
    pose = Moved(snapshot, pose, by);
    if (turn_rad != 0) pose = Turned(snapshot, pose, Vector3d::UnitZ(), turn_rad);
    view.pending = OnItsWay(context, instance, pose);
    view.nudged = true;
  });
  if (any_down || !view.nudged) return;
  view.nudged = false;
  if (view.pending) sink.Post(EditOf(*view.pending));
}

bool IsOpen(const FrameContext& context) {
  return context.annotation != nullptr && context.annotate_scene != nullptr;
}
/// Nothing is being decided: keys are for the selected object.
bool IsFree(const FrameContext& context) {
  return IsOpen(context) && !context.annotation->HasProposal() &&
         context.annotate->tool != AnnotateTool::kCut;
}
bool HasSelection(const FrameContext& context) {
  return IsFree(context) && context.annotation->Selected() != nullptr;
}
bool CanEdit(const FrameContext& context) {
  return HasSelection(context) && Editable(context, context.annotation->Selected());
}
/// Both can refine it, and either alone.
bool CanEditWithImages(const FrameContext& context) {
  return CanEdit(context) && context.annotation->has_sequence;
}
bool CutsNow(const FrameContext& context) {
  const AnnotateView& view = *context.annotate;
  return view.tool == AnnotateTool::kCut &&
         (view.crop_by_line ? !view.lasso_closed : !context.annotation->crop);
}
bool CanAccept(const FrameContext& context) {
  if (!IsOpen(context)) return false;
  const AnnotateTool tool = context.annotate->tool;
  return context.annotation->HasProposal() || tool == AnnotateTool::kPlace || CutsNow(context);
}

/// What Enter says: cut out, take what is proposed, or put the chosen model into the middle.
void Accept(const FrameContext& context, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  AnnotateView& view = *context.annotate;
  if (CutsNow(context)) return ProposeCrop(context, sink);
  if (!snapshot.HasProposal())
    return PlaceChosenModel(context, 0.5 * view.view_px.x(), 0.5 * view.view_px.y(), sink);
  if (snapshot.floor) {
    view.tool = AnnotateTool::kSelect;
    view.reset = true;
  }
  const auto ready = [](const auto& proposal) {
    return proposal && !proposal->running && proposal->problem.empty();
  };
  if (ready(snapshot.sequence_alignment) || ready(snapshot.crop)) view.tool = AnnotateTool::kSelect;
  AcceptProposal(context, view.candidate, sink);
}

/// What Esc says: a step back.
void StepBack(const FrameContext& context, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  if (view.tool == AnnotateTool::kCut && (!view.lasso.empty() || view.crop_box)) {
    DropCut(context, sink);
  } else if (context.annotation->HasProposal()) {
    sink.Post(CancelProposalCommand{});
  } else if (view.boxing) {
    view.boxing = false;
  } else if (view.tool != AnnotateTool::kSelect) {
    view.tool = AnnotateTool::kSelect;
  } else {
    sink.Post(SelectInstanceCommand{});
  }
}

bool HasObjects(const FrameContext& context) {
  return IsFree(context) && !context.annotation->instances.empty();
}
bool IsAnyHidden(const FrameContext& context) {
  const auto hidden = [](const AnnotatedInstance& instance) { return instance.hidden; };
  return IsFree(context) && std::any_of(context.annotation->instances.begin(),
                                        context.annotation->instances.end(), hidden);
}

void SelectAll(const FrameContext& context, CommandSink& sink) {
  std::vector<std::string> ids = SelectedInstances(context);
  for (const AnnotatedInstance& instance : context.annotation->instances) {
    if (!instance.hidden && std::find(ids.begin(), ids.end(), instance.id) == ids.end())
      ids.push_back(instance.id);
  }
  SelectInstances(context, std::move(ids), sink);
}

/// Hides or shows several objects as one edit.
void HideAll(const std::vector<std::string>& ids, bool hide, CommandSink& sink) {
  if (ids.empty()) return;
  ChangeInstanceCommand change;
  change.id = ids.front();
  change.and_also.assign(ids.begin() + 1, ids.end());
  change.set.hidden = hide;
  sink.Post(change);
}

void ShowAll(const FrameContext& context, CommandSink& sink) {
  std::vector<std::string> hidden;
  for (const AnnotatedInstance& instance : context.annotation->instances)
    if (instance.hidden) hidden.push_back(instance.id);
  HideAll(hidden, false, sink);
}

void HideOthers(const FrameContext& context, CommandSink& sink) {
  const std::vector<std::string> kept = SelectedInstances(context);
  std::vector<std::string> others;
  for (const AnnotatedInstance& instance : context.annotation->instances) {
    if (!instance.hidden && std::find(kept.begin(), kept.end(), instance.id) == kept.end())
      others.push_back(instance.id);
  }
  HideAll(others, true, sink);
}

void SelectBy(const FrameContext& context, int step, CommandSink& sink) {
  const auto& instances = context.annotation->instances;
  if (instances.empty()) return;
  const auto count = static_cast<int>(instances.size());
  int at = step > 0 ? -1 : count;
  for (int i = 0; i < count; ++i) {
    if (instances[static_cast<std::size_t>(i)].id == context.annotation->selected) at = i;
  }
  const int next = ((at + step) % count + count) % count;
  sink.Post(SelectInstanceCommand{instances[static_cast<std::size_t>(next)].id});
}

using Run = std::function<void(const FrameContext&, CommandSink&)>;

/// Does something with the selected object.
Run WithSelected(void (*run)(const FrameContext&, const AnnotatedInstance&, CommandSink&)) {
  return [run](const FrameContext& context, CommandSink& sink) {
    run(context, *context.annotation->Selected(), sink);
  };
}

/// Changes one value of the selected object.
template <typename Set>
Run Changes(Set set) {
  return [set](const FrameContext& context, CommandSink& sink) {
    const AnnotatedInstance& instance = *context.annotation->Selected();
    ChangeInstanceCommand change;
    change.id = instance.id;
    change.and_also = context.annotate->also_selected;
    set(instance, change.set);
    sink.Post(change);
  };
}

Run TakesTool(AnnotateTool tool) {
  return [tool](const FrameContext& context, CommandSink& sink) {
    context.annotate->tool = tool;
    sink.Post(CancelProposalCommand{});
  };
}

Run Turns(bool AnnotateView::*value) {
  return [value](const FrameContext& context, CommandSink&) {
    context.annotate->*value = !(context.annotate->*value);
  };
}

std::function<bool(const FrameContext&)> Is(bool AnnotateView::*value) {
  return [value](const FrameContext& context) {
    return context.annotate != nullptr && context.annotate->*value;
  };
}

/// A row of the help sheet for keys that are watched.
Action Watched(std::vector<KeyStroke> strokes, const char* help_keys, const char* help) {
  return {.keys = std::move(strokes), .help_keys = help_keys, .help = help};
}

ActionGroup MoveActions() {
  using namespace keys;
  return {"Move",
          {Watched({{kW}, {kA}, {kS}, {kD}, {kW, true}, {kA, true}, {kS, true}, {kD, true}},
                   "W A S D", "Move it along the floor by 5 mm (Shift: 5 cm)"),
           Watched({{kQ}, {kE}, {kQ, true}, {kE, true}}, "Q  E",
                   "Lower or raise it by 5 mm (Shift: 5 cm)"),
           Watched({{kZ}, {kX}, {kZ, true}, {kX, true}}, "Z  X",
                   "Turn it by 0.5\u00b0 (Shift: 5\u00b0)"),
           {.text = "Put it onto the floor",
            .keys = {{kG}},
            .run = PutOntoFloor,
            .help_keys = "G",
            .help = "Onto the floor",
            .is_offered = CanEdit}}};
}

ActionGroup AlignActions() {
  using namespace keys;
  return {"Align",
          {{.text = "Refine: align it to scan and images together",
            .keys = {{kI}},
            .run = WithSelected([](const FrameContext& context, const AnnotatedInstance& instance,
                                   CommandSink& sink) {
              sink.Post(RefineInstanceCommand{instance.id, context.annotate->on_floor});
            }),
            .help_keys = "I",
            .help = "Refine: align it to scan and images together (Shift: to the images alone)",
            .is_offered = CanEdit},
           {.text = "Refine by the images alone: align its outline to their edges",
            .keys = {{kI, true}},
            .run = WithSelected([](const FrameContext& context, const AnnotatedInstance& instance,
                                   CommandSink& sink) {
              sink.Post(RefineInstanceCommand{instance.id, context.annotate->on_floor,
                                              RefineBy::kImages});
            }),
            .is_offered = CanEditWithImages},
           {.text = "Refine by the scan alone",
            .run = WithSelected([](const FrameContext& context, const AnnotatedInstance& instance,
                                   CommandSink& sink) {
              sink.Post(
                  RefineInstanceCommand{instance.id, context.annotate->on_floor, RefineBy::kScan});
            }),
            .is_offered = CanEditWithImages},
           {.text = "Try all azimuths",
            .keys = {{kT}},
            .run = PlaceAgain,
            .help_keys = "T",
            .help = "Try all azimuths",
            .is_offered = CanEdit},
           {.text = "Accept",
            .keys = {{kEnter}, {kPadEnter}},
            .run = Accept,
            .help_keys = "Enter  Esc",
            .help = "Accept or discard; place the chosen model in the middle of the view",
            .is_offered = CanAccept},
           {.text = "Discard, or a step back",
            .keys = {{kEscape}},
            .run = StepBack,
            .is_offered = IsOpen},
           Watched({{kUp}, {kDown}}, "\u2191  \u2193", "Previous or next candidate")}};
}

ActionGroup EditActions() {
  using namespace keys;
  return {
      "Edit",
      {{.text = "Select the next object",
        .keys = {{kTab}},
        .run = [](const FrameContext& context, CommandSink& sink) { SelectBy(context, 1, sink); },
        .help_keys = "Tab",
        .help = "Select the next object (Shift: the previous one)",
        .is_offered = IsFree},
       {.text = "Select the previous object",
        .keys = {{kTab, true}},
        .run = [](const FrameContext& context, CommandSink& sink) { SelectBy(context, -1, sink); },
        .is_offered = IsFree},
       {.text = "Go to the next finding",
        .keys = {{kN}},
        .run = [](const FrameContext& context,
                  CommandSink& sink) { WalkFindings(context, 1, sink); },
        .help_keys = "N",
        .help = "Show what is probably wrong, one after another (Shift: back)",
        .is_offered = IsFree},
       {.text = "Go to the finding before",
        .keys = {{kN, true}},
        .run = [](const FrameContext& context,
                  CommandSink& sink) { WalkFindings(context, -1, sink); },
        .is_offered = IsFree},
       {.text = "Accept the finding: it is all right",
        .keys = {{kO}},
        .run = AcceptShownFinding,
        .help_keys = "O",
        .help = "The finding that is shown is all right; or, if it was accepted, open again",
        .text_when_on = "Reopen the finding that was accepted",
        .is_on = [](const FrameContext& context) { return ShownFinding(context)->accepted; },
        .is_offered =
            [](const FrameContext& context) {
              return IsFree(context) && !context.annotation->read_only &&
                     ShownFinding(context) != nullptr;
            }},
       {.text = "Hide it",
        .keys = {{kH}},
        .run = Changes([](const AnnotatedInstance& instance, InstanceChange& set) {
          set.hidden = !instance.hidden;
        }),
        .help_keys = "H  L  K",
        .help = "Hide it, lock it, mark it as coarse or fine",
        .text_when_on = "Show it",
        .is_on = [](const FrameContext& c) { return c.annotation->Selected()->hidden; },
        .is_offered = HasSelection},
       {.text = "Show all objects",
        .keys = {{kH, false, false, true}},
        .run = ShowAll,
        .help_keys = "Alt + H",
        .help = "Show all objects again (Shift + H: hide all but the selected ones)",
        .is_offered = IsAnyHidden},
       {.text = "Hide all others",
        .keys = {{kH, true}},
        .run = HideOthers,
        .is_offered = HasSelection},
       {.text = "Select all objects",
        .keys = {{kA, false, true}},
        .run = SelectAll,
        .help_keys = "Ctrl + A",
        .help = "Select all objects that show",
        .is_offered = HasObjects},
       {.text = "Select by a box",
        .keys = {{kB}},
        .run =
            [](const FrameContext& context, CommandSink&) {
              context.annotate->tool = AnnotateTool::kSelect;
              context.annotate->boxing = !context.annotate->boxing;
            },
        .help_keys = "B",
        .help = "Select by a box: drag it (with Shift or Ctrl it adds)",
        .is_offered = HasObjects},
       {.text = "Lock it",
        .keys = {{kL}},
        .run = Changes([](const AnnotatedInstance& instance, InstanceChange& set) {
          set.locked = !instance.locked;
        }),
        .text_when_on = "Unlock it",
        .is_on = [](const FrameContext& c) { return c.annotation->Selected()->locked; },
        .is_offered = HasSelection},
       {.text = "Mark it as coarse",
        .keys = {{kK}},
        .run = Changes([](const AnnotatedInstance& instance, InstanceChange& set) {
          set.fine = !instance.fine;
        }),
        .text_when_on = "Mark it as fine",
        .is_on = [](const FrameContext& c) { return !c.annotation->Selected()->fine; },
        .is_offered = HasSelection},
       {.text = "Delete it",
        .keys = {{kDelete}},
        .run = WithSelected(
            [](const FrameContext& context, const AnnotatedInstance& instance, CommandSink& sink) {
              sink.Post(RemoveInstanceCommand{instance.id, context.annotate->also_selected});
            }),
        .help_keys = "Del",
        .help = "Delete it",
        .is_offered = CanEdit},
       {.text = "Duplicate it",
        .keys = {{kD, false, true}},
        .run = Duplicate,
        .help_keys = "Ctrl + D",
        .help = "Duplicate it",
        .is_offered = HasSelection},
       {.text = "Unlock its tilt",
        .run = Changes([](const AnnotatedInstance& instance, InstanceChange& set) {
          set.may_tilt = !instance.may_tilt;
        }),
        .text_when_on = "Lock its tilt",
        .is_on = [](const FrameContext& c) { return c.annotation->Selected()->may_tilt; },
        .is_offered = CanEdit},
       {.text = "Unlock its scale",
        .run = Changes([](const AnnotatedInstance& instance, InstanceChange& set) {
          set.may_scale = !instance.may_scale;
        }),
        .text_when_on = "Lock its scale",
        .is_on = [](const FrameContext& c) { return c.annotation->Selected()->may_scale; },
        .is_offered = CanEdit},
       {.text = "Copy it",
        .keys = {{kC, false, true}},
        .run = WithSelected([](const FrameContext& context, const AnnotatedInstance& instance,
                               CommandSink&) { CopyInstance(context, instance); }),
        .help_keys = "Ctrl + C  V",
        .help = "Copy it; paste a copy beside it (Shift: its pose onto the selected object)",
        .is_offered = HasSelection},
       {.text = "Paste a copy beside the copied object",
        .keys = {{kV, false, true}},
        .run =
            [](const FrameContext& context, CommandSink& sink) {
              sink.Post(DuplicateInstanceCommand{context.annotate->copied_id});
            },
        .is_offered =
            [](const FrameContext& context) {
              return IsFree(context) && !context.annotation->read_only &&
                     context.annotation->Find(context.annotate->copied_id) != nullptr;
            }},
       {.text = "Paste the pose",
        .keys = {{kV, true, true}},
        .run = WithSelected(
            [](const FrameContext& context, const AnnotatedInstance& instance, CommandSink& sink) {
              sink.Post(SetInstancePoseCommand{instance.id, *context.annotate->copied});
            }),
        .is_offered = [](const FrameContext& context) {
          return CanEdit(context) && context.annotate->copied.has_value();
        }}}};
}

ActionGroup ToolActions() {
  using namespace keys;
  return {
      "Place",
      {{.text = "Choose a model by its letters",
        .keys = {{kM}},
        .run = Posts(ShowPaletteCommand{true, "Place"}),
        .help_keys = "M",
        .help = "Choose a model to place: type some of its letters",
        .is_offered =
            [](const FrameContext& context) {
              return IsOpen(context) && !context.annotation->models->empty();
            }},
       {.text = "Click on the floor", .run = TakesTool(AnnotateTool::kFloor), .is_offered = IsOpen},
       {.text = "Find the floor",
        .run = Posts(FindFloorCommand{}),
        .is_offered =
            [](const FrameContext& context) {
              return IsFree(context) && context.annotation->ready_to_align;
            }},
       {.text = "Cut an object out of the scan",
        .run = TakesTool(AnnotateTool::kCut),
        .is_offered = IsOpen},
       {.text = "Register the sequence",
        .run = TakesTool(AnnotateTool::kSequence),
        .is_offered = [](const FrameContext& context) {
          return IsOpen(context) && context.annotation->has_sequence;
        }}}};
}

ActionGroup ProjectActions() {
  using namespace keys;
  const auto can_write = [](const FrameContext& context) {
    return IsOpen(context) && !context.annotation->read_only;
  };
  return {"Project",
          {{.text = "Undo",
            .keys = {{kZ, false, true}},
            .run = Posts(UndoCommand{}),
            .help_keys = "Ctrl + Z  Y",
            .help = "Undo, redo",
            .is_offered = IsOpen},
           {.text = "Redo",
            .keys = {{kY, false, true}, {kZ, true, true}},
            .run = Posts(RedoCommand{}),
            .is_offered = IsOpen},
           {.text = "Save",
            .keys = {{kS, false, true}},
            .run = Posts(SaveProjectCommand{}),
            .help_keys = "Ctrl + S",
            .help = "Save",
            .is_offered = can_write},
           {.text = "Export",
            .keys = {{kE, false, true}},
            .run = Turns(&AnnotateView::open_export),
            .help_keys = "Ctrl + E",
            .help = "Export",
            .is_offered = IsOpen},
           {.text = "Queue: the scans of a folder, and how far each is",
            .keys = {{kO, true, true}},
            .run = Turns(&AnnotateView::open_queue),
            .help_keys = "Ctrl + Shift + O",
            .help = "Queue of scans; hand over for review",
            .is_offered = IsOpen},
           {.text = "Compare with another annotator's project",
            .run = [](const FrameContext& context,
                      CommandSink&) { AskPath(context, AgreementQuestion(*context.annotate)); },
            .is_offered = IsOpen},
           {.text = "Save as, drafts of a run, annotator",
            .keys = {{kS, true, true}},
            .run = Turns(&AnnotateView::open_more),
            .is_offered = IsOpen}}};
}

ActionGroup LayerActions() {
  const auto layer = [](const char* show, const char* hide, bool AnnotateView::*value) {
    return Action{.text = show,
                  .run = Turns(value),
                  .text_when_on = hide,
                  .is_on = Is(value),
                  .is_offered = IsOpen};
  };
  return {"Layers",
          {layer("Show the scan", "Hide the scan", &AnnotateView::scan),
           layer("Show the models", "Hide the models", &AnnotateView::models),
           layer("Show the grid", "Hide the grid", &AnnotateView::grid),
           layer("Show the path of the cameras", "Hide the path of the cameras",
                 &AnnotateView::cameras),
           layer("Keep on the floor what stands on it", "Let what stands on the floor rise",
                 &AnnotateView::on_floor)}};
}

}  // namespace

std::vector<ActionGroup> AnnotateActions() {
  return {MoveActions(), AlignActions(),   EditActions(),
          ToolActions(), ProjectActions(), LayerActions()};
}

void PostAnnotateShortcuts(const FrameContext& context, CommandSink& sink) {
  if (!IsOpen(context)) return;
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput || ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopupId)) return;
  if (io.KeyCtrl) return;
  AnnotateView& view = *context.annotate;
  if (view.tool == AnnotateTool::kCut && view.crop_box) NudgeBox(context, *view.crop_box);
  if (const auto& placement = context.annotation->placement) {
    const int count = static_cast<int>(placement->candidates.size());
    if (ImGui::IsKeyPressed(keys::kDown)) view.candidate = std::min(view.candidate + 1, count - 1);
    if (ImGui::IsKeyPressed(keys::kUp)) view.candidate = std::max(view.candidate - 1, 0);
  }
  if (CanEdit(context)) PostNudges(context, *context.annotation->Selected(), sink);
}

}  // namespace plumbline
