// SPDX-License-Identifier: Apache-2.0
#include "app/window/annotate/annotate_workspace.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "engine/base/overloaded.h"
#include "engine/geometry/angles.h"
#include "engine/session/annotation_queue.h"
#include "ui/annotate/annotate_actions.h"
#include "ui/annotate/annotate_edits.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_view_menu.h"
#include "ui/files/kept_value.h"
#include "ui/framework/widgets.h"
#include "ui/scene/annotate_scene.h"

namespace plumbline {
namespace {

nlohmann::json MatrixOf(const Eigen::Isometry3d& pose) {
  nlohmann::json rows = nlohmann::json::array();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({pose.matrix()(row, 0), pose.matrix()(row, 1), pose.matrix()(row, 2),
                    pose.matrix()(row, 3)});
  }
  return rows;
}

nlohmann::json VectorOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Under which the views of what was opened are kept.
std::string KeyOf(const std::string& source) {
  return std::filesystem::absolute(source).lexically_normal().string();
}

const char* NameOf(AnnotateTool tool) {
  switch (tool) {
    case AnnotateTool::kFloor:
      return "floor";
    case AnnotateTool::kPlace:
      return "place";
    case AnnotateTool::kSequence:
      return "sequence";
    case AnnotateTool::kCut:
      return "cut";
    case AnnotateTool::kSelect:
      break;
  }
  return "select";
}

}  // namespace

AnnotateWorkspace::AnnotateWorkspace(AnnotationChoice defaults, bool software_gl,
                                     std::function<void()> wake)
    : defaults_(std::move(defaults)),
      software_gl_(software_gl),
      wake_(std::move(wake)),
      actions_(AnnotateActions()),
      scene_panel_(MakeAnnotatePanel("annotate_scene")),
      models_(MakeAnnotatePanel("annotate_models")),
      instances_(MakeAnnotatePanel("annotate_instances")),
      floor_(MakeAnnotatePanel("annotate_floor")),
      candidates_(MakeAnnotatePanel("annotate_candidates")),
      refinement_(MakeAnnotatePanel("annotate_refinement")),
      images_(MakeAnnotatePanel("annotate_images")),
      instance_(MakeAnnotatePanel("annotate_instance")),
      sequence_(MakeAnnotatePanel("annotate_sequence")),
      frame_(MakeAnnotatePanel("annotate_frame")),
      masks_(MakeAnnotatePanel("annotate_masks")),
      crop_(MakeAnnotatePanel("annotate_crop")) {}

AnnotateWorkspace::~AnnotateWorkspace() = default;

bool AnnotateWorkspace::Takes(const std::string& path) const {
  return IsForAnnotation(path) || IsQueue(path);
}

void AnnotateWorkspace::Open(const std::string& path, std::optional<int>, FrameContext& context) {
  process_.reset();
  KeepViews();
  const ScanLook look = view_.scan_look;
  view_ = {};
  view_.scan_look = look;
  // Made anew: a scene remembers its camera and its actors.
  scene_ = CreateAnnotateScene(software_gl_);
  context.annotate = &view_;
  context.annotate_scene = scene_.get();
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    defaults_.queue = path;  // what is opened from the list belongs to it, too
    view_.open_queue = true;
  }
  told_placing_ = false;
  AnnotationChoice choice = defaults_;
  choice.path = source_ = path;
  view_.saved_views =
      SavedViewsFromJson(kept_views_.value(KeyOf(source_), nlohmann::json::array()));
  process_ = std::make_unique<AnnotationProcess>(std::move(choice), wake_);
  ReadSlots(context);
}

void AnnotateWorkspace::KeepViews() {
  if (source_.empty()) return;
  if (view_.saved_views.empty())
    kept_views_.erase(KeyOf(source_));
  else
    kept_views_[KeyOf(source_)] = ToJson(view_.saved_views);
}

void AnnotateWorkspace::ReadSlots(FrameContext& context) {
  if (process_ == nullptr) return;
  auto snapshot = process_->Snapshot();
  if (snapshot == context.annotation) return;
  if (context.annotation != nullptr) FollowSnapshot(*context.annotation, *snapshot, view_);
  context.annotation = std::move(snapshot);
  ++context.annotation_version;
}

Panel& AnnotateWorkspace::TaskPanel(const FrameContext& context) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  if (snapshot.placement) return *candidates_;
  if (snapshot.refinement) return *refinement_;
  if (snapshot.sequence_alignment) return *sequence_;
  if (snapshot.crop || view_.tool == AnnotateTool::kCut) return *crop_;
  if (view_.tool == AnnotateTool::kSequence && !snapshot.floor) return *sequence_;
  const bool first =
      !snapshot.gravity_known && snapshot.instances.empty() && view_.tool != AnnotateTool::kPlace;
  if (snapshot.floor || first || view_.tool == AnnotateTool::kFloor) return *floor_;
  return *instance_;
}

void AnnotateWorkspace::Draw(FrameContext& context, const LayoutRect& rect, CommandSink& sink) {
  const float gap = context.Scaled(6), margin = context.Scaled(8);
  const LayoutRect room{{rect.low.x + margin, rect.low.y}, {rect.high.x - margin, rect.high.y}};
  const float left_x = room.low.x + static_cast<float>(std::round(left_ * room.width()));
  const float middle_y = room.low.y + static_cast<float>(std::round(models_share_ * room.height()));
  DrawPanel(context, {room.low, {left_x, middle_y}}, *models_, sink);
  DrawPanel(context, {{room.low.x, middle_y + gap}, {left_x, room.high.y}}, *instances_, sink);
  const float right_x = room.low.x + static_cast<float>(std::round(right_ * room.width()));
  const bool images = context.annotation->has_sequence;
  const bool picks = images && view_.tool == AnnotateTool::kSequence;
  constexpr double kFrameShare = 0.46;  // where the frame begins that is picked in
  const double share = picks ? kFrameShare : images_share_;
  const float images_y =
      images ? room.low.y + static_cast<float>(std::round(share * room.height())) : room.high.y;
  DrawPanel(context, {{left_x + gap, room.low.y}, {right_x, images_y}}, *scene_panel_, sink);
  if (images) {
    DrawPanel(context, {{left_x + gap, images_y + gap}, {right_x, room.high.y}},
              picks         ? *frame_
              : view_.masks ? *masks_
                            : *images_,
              sink);
  }
  Preview(context);
  NoteActivity();
  DrawPanel(context, {{right_x + gap, room.low.y}, room.high}, TaskPanel(context), sink);
}

void AnnotateWorkspace::NoteActivity() {
  constexpr double kTellEvery_s = 2;
  const ImGuiIO& io = ImGui::GetIO();
  const bool buttons =
      std::any_of(std::begin(io.MouseDown), std::end(io.MouseDown), [](bool down) { return down; });
  const bool pressed =
      std::any_of(std::begin(io.KeysDown), std::end(io.KeysDown), [](bool down) { return down; });
  const bool input = io.MouseDelta.x != 0 || io.MouseDelta.y != 0 || io.MouseWheel != 0 ||
                     buttons || pressed || !io.InputQueueCharacters.empty();
  const bool placing = view_.tool == AnnotateTool::kPlace;
  const double now_s = ImGui::GetTime();
  const bool due = input && now_s - activity_s_ >= kTellEvery_s;
  if (!due && placing == told_placing_) return;
  activity_s_ = now_s;
  told_placing_ = placing;
  process_->Post(ActivityCommand{placing});
}

void AnnotateWorkspace::Preview(const FrameContext& context) {
  std::optional<PendingPose> judged = view_.pending;
  if (const auto& placement = context.annotation->placement; placement && !judged) {
    const auto index = static_cast<std::size_t>(std::max(0, view_.candidate));
    if (index < placement->candidates.size()) {
      judged = PendingPose{placement->instance, placement->candidates[index].scan_from_object, {}};
    }
  }
  const bool same =
      judged.has_value() == previewed_.has_value() &&
      (!previewed_ || judged->scan_from_object.matrix() == previewed_->scan_from_object.matrix());
  if (same) return;
  previewed_ = judged;
  if (previewed_) process_->Post(PreviewPoseCommand{previewed_->id, previewed_->scan_from_object});
}

WorkspaceTab AnnotateWorkspace::tab() const {
  return {WorkspaceId::kAnnotate, "top.annotate", "Annotate",
          "Workspace: place models in a scan, to make the truth that maps are judged by."};
}

bool AnnotateWorkspace::IsOpen(const FrameContext& context) const {
  return context.annotation != nullptr && !context.annotation->project_file.empty();
}

void AnnotateWorkspace::DrawBar(const FrameContext& context, const LayoutRect& rect,
                                CommandSink& sink) {
  DrawProjectBar(context, rect, sink);
}

StatusLine AnnotateWorkspace::status_line(const FrameContext& context) const {
  StatusLine line;
  line.text = AnnotationStatus(context, line.failed);
  return line;
}

void AnnotateWorkspace::AddPaletteEntries(const FrameContext& context,
                                          std::vector<PaletteEntry>& entries) const {
  if (context.annotation == nullptr) return;
  for (const AnnotationModel& model : *context.annotation->models) {
    entries.push_back(
        {"Place " + model.name, model.category,
         [&context, name = model.name](CommandSink& sink) { ChooseModel(context, name, sink); }});
  }
  for (const AnnotatedInstance& instance : context.annotation->instances)
    entries.push_back(EntryFor("Select " + instance.id, SelectInstanceCommand{instance.id}));
  AddViewEntries(context, entries);
}

std::string AnnotateWorkspace::WouldBeLost(const FrameContext& context) const {
  if (context.annotation == nullptr || context.annotation->journal_problem.empty()) return {};
  return "Edits that are not on disk would be lost: save them elsewhere, or do it again to give "
         "them up.";
}

void AnnotateWorkspace::WatchKeys(const FrameContext& context, CommandSink& sink) {
  PostAnnotateShortcuts(context, sink);
}

void AnnotateWorkspace::Handle(const AnnotationCommand& command) {
  if (const auto* set = std::get_if<SetAnnotatorCommand>(&command)) {
    defaults_.annotator = set->name;  // for the next scan, too
  }
  if (process_ != nullptr) NotePosted(command, process_->Post(command), view_);
}

void AnnotateWorkspace::Handle(const ViewCommand& command, FrameContext&) {
  if (scene_ == nullptr) return;
  std::visit(Overloaded{[&](const FocusSelectionCommand&) { view_.focus = true; },
                        [&](const ResetViewCommand&) { view_.reset = true; },
                        [&](const ViewDirectionCommand& c) {
                          scene_->SetDirection(c.azimuth_rad, c.elevation_rad);
                        }},
             command);
}

void AnnotateWorkspace::AddState(const FrameContext& context, nlohmann::json& state) const {
  if (context.annotation == nullptr) return;
  const AnnotationSnapshot& snapshot = *context.annotation;
  using State = AnnotationSnapshot::State;
  nlohmann::json annotate = {{"state", snapshot.state == State::kReady    ? "ready"
                                       : snapshot.state == State::kFailed ? "failed"
                                                                          : "opening"},
                             {"busy", snapshot.busy},
                             {"failure", snapshot.failure},
                             {"project", snapshot.project_name},
                             {"modified", snapshot.modified},
                             {"read_only", snapshot.read_only},
                             {"notices", snapshot.notices},
                             {"recovered", snapshot.num_recovered},
                             {"journal_problem", snapshot.journal_problem},
                             {"answer", snapshot.answer},
                             {"undo", snapshot.undo_label.value_or("")},
                             {"redo", snapshot.redo_label.value_or("")},
                             {"scan_points", snapshot.scan_points},
                             {"aligns", snapshot.ready_to_align},
                             {"models", snapshot.models->size()},
                             {"floor_known", snapshot.floor_known},
                             {"level_from_scan", MatrixOf(snapshot.level_from_scan)},
                             {"selected", snapshot.selected},
                             {"tool", NameOf(view_.tool)},
                             {"candidate", view_.candidate},
                             {"views", view_.saved_views.size()},
                             {"scan_look", ToJson(view_.scan_look)},
                             {"proposal", snapshot.floor                ? "floor"
                                          : snapshot.placement          ? "placement"
                                          : snapshot.refinement         ? "refinement"
                                          : snapshot.sequence_alignment ? "sequence"
                                          : snapshot.crop               ? "crop"
                                                                        : ""},
                             {"instances", nlohmann::json::array()}};
  if (scene_ != nullptr) annotate["eye_in_level"] = VectorOf(scene_->Sight(0, 0).eye);
  for (const AnnotatedInstance& instance : snapshot.instances) {
    annotate["seconds_spent"][instance.id] = instance.seconds_spent;
    annotate["instances"].push_back({{"id", instance.id},
                                     {"model", instance.model},
                                     {"quality", instance.fine ? "fine" : "coarse"},
                                     {"hidden", instance.hidden},
                                     {"locked", instance.locked},
                                     {"note", instance.note},
                                     {"may_tilt", instance.may_tilt},
                                     {"scan_from_object", MatrixOf(instance.scan_from_object)}});
  }
  annotate["stage"] = NameOf(snapshot.stage);
  state["annotate.queue"] = snapshot.queue ? snapshot.queue->entries.size() : 0;
  annotate["doubted_size_m"] = snapshot.doubted_size_m.value_or(0);
  annotate["findings"] = nlohmann::json::array();
  for (const FindingView& finding : snapshot.checklist.findings) {
    annotate["findings"].push_back(
        {{"kind", finding.kind}, {"instances", finding.instances}, {"sentence", finding.sentence}});
  }
  state["annotate.findings"] = snapshot.checklist.findings.size();
  state["annotate.comparing"] = snapshot.checklist.comparing;
  if (snapshot.exported) annotate["differences"] = snapshot.exported->differences;
  annotate["exported"] = !snapshot.exported                          ? ""
                         : snapshot.exported->running                ? "running"
                         : snapshot.exported->asks                   ? "asks"
                         : !snapshot.exported->open_findings.empty() ? "findings"
                         : snapshot.exported->problem.empty()        ? "done"
                                                                     : snapshot.exported->problem;
  if (snapshot.box) annotate["box_points"] = snapshot.box->points->size();
  if (view_.crop_box) {
    annotate["crop_box"] = {{"center", VectorOf(view_.crop_box->center)},
                            {"size_m", VectorOf(view_.crop_box->size_m)},
                            {"azimuth_rad", view_.crop_box->azimuth_rad}};
  }
  if (snapshot.checks) {
    state["annotate.images"] = snapshot.checks->images.size();
    state["annotate.agreement_percent"] = std::lround(100 * snapshot.checks->agreement);
    annotate["agreement"] = snapshot.checks->agreement;
    for (const ImageCheckView& image : snapshot.checks->images) {
      annotate["images"].push_back({{"frame", image.frame},
                                    {"agreement", image.agreement},
                                    {"eye_in_level", VectorOf(snapshot.level_from_scan *
                                                              image.scan_from_cam.translation())}});
    }
  }
  if (const auto& placement = snapshot.placement) {
    annotate["placement_running"] = placement->running;
    annotate["placement_images"] = placement->images;
    annotate["placement_seconds"] = placement->seconds;
    for (const PlacementCandidate& candidate : placement->candidates) {
      annotate["candidates"].push_back({{"azimuth_deg", candidate.azimuth_rad * kDegPerRad},
                                        {"fitness", candidate.fitness},
                                        {"rmse_m", candidate.rmse_m},
                                        {"agreement", candidate.agreement.value_or(-1)},
                                        {"from_images", candidate.from_images}});
    }
  }
  if (const auto& refinement = snapshot.refinement) {
    annotate["refining"] = refinement->running;
    annotate["iteration"] = refinement->iteration;
    annotate["refinement"] = {{"azimuth_rad", refinement->azimuth_rad},
                              {"horizontal_m", refinement->horizontal_m},
                              {"height_m", refinement->height_m},
                              {"azimuth_std_rad", refinement->azimuth_std_rad},
                              {"horizontal_std_m", refinement->horizontal_std_m},
                              {"height_std_m", refinement->height_std_m},
                              {"fitness", refinement->fitness},
                              {"agreement", refinement->agreement},
                              {"found", refinement->found.size()},
                              {"contradict", refinement->contradict},
                              {"held_out", refinement->agreement_held_out.value_or(-1)},
                              {"problem", refinement->problem}};
  }
  for (const PairView& pair : snapshot.pairs) {
    annotate["pairs"].push_back({{"frame", pair.frame},
                                 {"in_scan", VectorOf(pair.in_scan)},
                                 {"residual_px", pair.residual_px}});
  }
  if (const auto& crop = snapshot.crop) {
    annotate["crop"] = {{"id", crop->id},
                        {"problem", crop->problem},
                        {"points", crop->points == nullptr ? 0 : crop->points->size()},
                        {"faces", crop->num_faces},
                        {"size_m", VectorOf(crop->size_m)}};
  }
  if (const auto& found = snapshot.sequence_alignment) {
    annotate["sequence"] = {{"scan_from_world", MatrixOf(found->scan_from_world)},
                            {"problem", found->problem},
                            {"azimuth_std_rad", found->azimuth_std_rad},
                            {"rmse_m", found->rmse_m}};
  }
  state["annotate.crop"] = snapshot.crop ? snapshot.crop->id : "";
  state["annotate.pairs"] = snapshot.pairs.size();
  state["annotate.frame"] =
      snapshot.frame && !snapshot.frame->image.empty() ? snapshot.frame->frame : -1;
  state["annotate.registered"] = snapshot.sequence_registered;
  // Flat names, so that scripts can wait for them.
  for (const char* key : {"state", "busy", "modified", "read_only", "undo", "redo", "aligns",
                          "floor_known", "selected", "tool", "proposal", "candidate", "exported",
                          "recovered", "doubted_size_m", "stage"}) {
    state[std::string("annotate.") + key] = annotate[key];
  }
  state["annotate.unsafe"] = !snapshot.journal_problem.empty();
  state["annotate.box"] = view_.crop_box.has_value();
  state["annotate.instances"] = snapshot.instances.size();
  state["annotate.models"] = snapshot.models->size();
  state["annotate.running"] = (snapshot.placement && snapshot.placement->running) ||
                              (snapshot.refinement && snapshot.refinement->running) ||
                              (snapshot.crop && snapshot.crop->running) ||
                              (snapshot.sequence_alignment && snapshot.sequence_alignment->running);
  state["annotate.candidates"] = snapshot.placement ? snapshot.placement->candidates.size() : 0;
  state["annotate"] = std::move(annotate);
}

void AnnotateWorkspace::SaveSettings(const FrameContext&, nlohmann::json& settings) const {
  settings["annotate"] = {{"left", left_},
                          {"right", right_},
                          {"models", models_share_},
                          {"scan_look", ToJson(view_.scan_look)},
                          {"annotator", defaults_.annotator}};
  nlohmann::json views = kept_views_;
  if (!view_.saved_views.empty())
    views[KeyOf(source_)] = ToJson(view_.saved_views);
  else if (!source_.empty())
    views.erase(KeyOf(source_));
  settings["annotate"]["views"] = std::move(views);
}

void AnnotateWorkspace::LoadSettings(const nlohmann::json& settings, FrameContext&) {
  const nlohmann::json own = KeptObject(settings, "annotate");
  left_ = std::clamp(KeptValue(own, "left", left_), 0.1, 0.4);
  right_ = std::clamp(KeptValue(own, "right", right_), 0.55, 0.9);
  models_share_ = std::clamp(KeptValue(own, "models", models_share_), 0.15, 0.85);
  defaults_.annotator = KeptValue(own, "annotator", defaults_.annotator);
  view_.scan_look = ScanLookFromJson(KeptObject(own, "scan_look"));
  kept_views_ = KeptObject(own, "views");
}

}  // namespace plumbline
