// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/inspect_workspace.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "engine/base/overloaded.h"
#include "engine/dataset/sequence.h"
#include "engine/geometry/gravity.h"
#include "engine/runtime/run_file_place.h"
#include "engine/runtime/running_graph.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/snapshot/sequence_view.h"
#include "ui/framework/particle_place.h"
#include "ui/scene/map_scene.h"

namespace plumbline {
namespace {

constexpr Pace kPresentPace{0.01, 0.01}, kBlinkPace{0, 0.05};
constexpr int kParticleHypothesis = 3;  ///< Where a ProbeView has the particle that was asked for.

}  // namespace

InspectWorkspace::InspectWorkspace(InspectOptions options, bool software_gl, FrameContext& context,
                                   CommandSink& window, std::function<void()> wake)
    : options_(std::move(options)),
      window_(window),
      wake_(std::move(wake)),
      scene_(CreateMapScene(software_gl)),
      actions_(InspectActions()),
      bookmarks_(wake_),
      networks_(wake_),
      batches_(wake_) {
  for (const PanelEntry& entry : InspectPanels()) {
    owned_.push_back(MakePanel(entry));
    panels_.push_back(owned_.back().get());
  }
  views_ = std::make_unique<ImageViews>(PanelsAt(PanelPlace::kImageView));
  what_if_ = std::make_unique<WhatIf>(
      [this](const std::string& path) { return options_.opener(path, with_); }, options_.inputs,
      options_.program_version, wake_);
  if (options_.graph) graph_ = std::make_unique<GraphProcess>(std::move(*options_.graph), wake_);
  context.playback = std::make_shared<const PlaybackView>();
  context.viewport = &viewport_;
  context.scene = scene_.get();
}

InspectWorkspace::~InspectWorkspace() {
  reopened_.reset();
  process_.reset();
  what_if_.reset();
}

WorkspaceTab InspectWorkspace::tab() const {
  return {WorkspaceId::kInspect, "top.inspect", "Inspect",
          "Workspace: play a sequence through the mapper, or a recorded run, and see what it sees "
          "and believes."};
}

std::vector<Panel*> InspectWorkspace::PanelsAt(PanelPlace place) const {
  std::vector<Panel*> there;
  for (std::size_t i = 0; i < panels_.size(); ++i) {
    if (InspectPanels()[i].place == place) there.push_back(panels_[i]);
  }
  return there;
}

void InspectWorkspace::UseModels(const std::string& folder) {
  with_.models = folder;
  what_if_->UseModels(folder);
}

void InspectWorkspace::Open(const std::string& path, std::optional<int> frame,
                            FrameContext& context) {
  reopened_.reset();
  process_.reset();
  if (path != source_) with_ = {.models = with_.models};
  source_ = path;
  MappingProcess::OpenSource open;
  if (NamesGraph(path)) {
    open = OpenGraph(path);
  } else {
    if (graph_source_.empty()) graph_source_ = path;
    open = options_.opener(path, with_);
  }
  Begin(std::make_unique<MappingProcess>(std::move(open), frame, wake_), context);
}

MappingProcess::OpenSource InspectWorkspace::OpenGraph(const std::string& place) {
  auto found = FindRunningGraph(place, kViewerName);
  if (!found.ok()) return [error = found.error()](const WorkContext&) { return error; };
  source_ = graph_source_ = found->run.string();
  graph_ = std::make_unique<GraphProcess>(std::move(found->graph), wake_);
  return options_.opener(source_, with_);
}

void InspectWorkspace::Begin(std::unique_ptr<MappingProcess> process, FrameContext& context) {
  process_ = std::move(process);
  watched_by_ = nullptr;
  context.sequence = nullptr;
  context.snapshot = nullptr;
  context.analysis = nullptr;
  context.history = nullptr;
  context.truths = nullptr;
  context.selection = {};
  context.selection.object = options_.select;
  auto_select_ = options_.select.value <= 0;
  context.bare = is_figure();
  context.look_through =
      options_.layout != nullptr && std::string_view(options_.layout->name) == "through";
  context.source = source_;
  ++context.source_version;
  context.bookmarks.clear();
  bookmarks_known_ = bookmarks_changed_ = false;
  bookmarks_.Read(BookmarkFile(source_, options_.settings));
  what_if_->Opened(context);
  context.playback = process_->Playback();
}

void InspectWorkspace::Reopen(const UseNetworksCommand& networks, const FrameContext& context) {
  if (source_.empty() || context.playback->recorded) return;
  reopened_with_ = with_;
  if (!networks.edges.empty()) reopened_with_.edges = networks.edges;
  if (!networks.detector.empty()) reopened_with_.detector = networks.detector;
  if (context.playback->options != nullptr) reopened_with_.options = *context.playback->options;
  reopened_.reset();
  reopened_ = std::make_unique<MappingProcess>(options_.opener(source_, reopened_with_),
                                               std::nullopt, wake_);
}

void InspectWorkspace::TakeReopened(FrameContext& context) {
  const bool failed =
      reopened_ != nullptr && reopened_->Playback()->state == PlaybackState::kFailed;
  if (failed && !networks_sheet_.is_open()) {  // which would say so
    window_.Post(NoteCommand{"Nothing has changed: " + reopened_->Playback()->message});
    reopened_.reset();
  }
  context.reopening = reopened_ != nullptr ? reopened_->Playback() : nullptr;
  if (reopened_ == nullptr || reopened_->Playback()->options == nullptr) return;  // not open yet
  const std::shared_ptr<const PlaybackView> before = process_->Playback();
  with_ = reopened_with_;
  Begin(std::move(reopened_), context);
  context.reopening = nullptr;
  process_->Post(SetSpeedCommand{before->speed});
  if (before->mapping)
    process_->Post(FollowNewestCommand{});
  else if (before->state == PlaybackState::kPlaying)
    process_->Post(PlayCommand{});
  const std::filesystem::path kept = before->recording;
  const bool keeps = !kept.empty() && !IsTemporaryRun(kept);
  window_.Post(NoteCommand{
      keeps ? "Mapping again from the first frame, into " +
                  std::filesystem::path(process_->Playback()->recording).filename().string() +
                  "; the run before stays in " + kept.filename().string()
            : std::string("Mapping again from the first frame")});
}

/// Once for what could not be opened.
void InspectWorkspace::LookForRemedy(FrameContext& context) {
  const bool failed =
      context.sequence == nullptr && context.playback->state == PlaybackState::kFailed;
  if (!failed || with_.find_poses) context.lacks_poses = false;
  // Where poses were asked for, something else was the matter.
  if (!failed || with_.find_poses || remedy_sought_for_ == context.source_version) return;
  remedy_sought_for_ = context.source_version;
  std::error_code ignored;
  if (!std::filesystem::is_directory(source_, ignored)) return;
  const auto sequence = OpenSequence(source_);
  if (!sequence.ok() || NumPosedFrames(**sequence) > 0) return;
  context.lacks_poses = true;
  context.has_imu = (*sequence)->has_imu();
}

void InspectWorkspace::LookAtNetwork(const std::string& file) {
  networks_sheet_.OpenWith(file);
  networks_.LookAt(file);
}

void InspectWorkspace::LookAtBatch(const std::string& path) {
  batch_sheet_.Open(true);
  batches_.Read(std::filesystem::absolute(path));
}

void InspectWorkspace::Compare(const std::string& run, FrameContext& context) {
  what_if_->Compare(run, context);
}

void InspectWorkspace::ReadSlots(FrameContext& context) {
  context.selection.hovered = std::exchange(hovered_now_, -1);
  context.ask_frame = std::exchange(ask_frame_, false);
  AddBookmarksRead(context);
  context.networks = networks_.View();
  const bool mapped_by_graph = graph_ != nullptr && source_ == graph_source_;
  context.graph = mapped_by_graph ? graph_->View() : nullptr;
  TakeReopened(context);
  if (process_ == nullptr) return;
  AskForWhatIsNeeded(context);
  context.playback = process_->Playback();
  context.sequence = process_->Sequence();
  LookForRemedy(context);
  context.probe = process_->Probe();
  context.history = process_->History();
  context.timings = process_->Timings();
  context.truths = process_->Truths();
  auto snapshot = context.first_snapshot = process_->Snapshot();
  what_if_->ReadSlots(context, process_->Header(), snapshot);
  if (snapshot != context.snapshot) {
    context.snapshot = std::move(snapshot);
    ++context.snapshot_version;
    if (context.selection.particle >= 0) context.selection.particle = -1;
  }
  context.first_looks = looks_.Of(*context.playback);
  const auto& looks = context.shows_other ? context.other->looks : context.first_looks;
  if (looks != context.looks) ++context.looks_version;
  context.looks = looks;
  // Read after the snapshot, before which it is published.
  MappingProcess* other = what_if_->shown_process(context);
  context.analysis = (other != nullptr ? other : process_.get())->Analysis();
  if (context.analysis != nullptr && context.analysis->frame != context.snapshot)
    context.analysis = nullptr;
  if (auto_select_ && context.snapshot != nullptr) SelectByItself(context);
  if (options_.present && context.snapshot != nullptr) {
    options_.present = false;
    Present(true, context);
    quit_after_presenting_ = presenter_.active();
  }
}

void InspectWorkspace::AskForWhatIsNeeded(const FrameContext& context) {
  needed_.object = context.selection.object;
  MappingProcess* other = what_if_->shown_process(context);
  MappingProcess* shown = other != nullptr ? other : process_.get();
  if (shown != watched_by_ || needed_ != watched_) {
    watched_by_ = shown;
    watched_ = needed_;
    shown->Post(watched_);
  }
  needed_ = {};
}

/// Keeps what is selected for as long as it shows; then the object that shows largest.
void InspectWorkspace::SelectByItself(FrameContext& context) const {
  const ObjectReport* selected = context.SelectedObject();
  if (selected != nullptr && selected->updated) return;
  float largest = 0;
  for (const ObjectReport& object : context.snapshot->report.objects) {
    if (!object.updated || object.visible_box.empty()) continue;
    const float area = object.visible_box.width() * object.visible_box.height() *
                       (object.state == ObjectState::kConfirmed ? 4.0f : 1.0f);
    if (area <= largest) continue;
    largest = area;
    context.selection.object = object.id;
  }
}

void InspectWorkspace::Handle(const PlaybackCommand& command, FrameContext& context) {
  const auto* probe = std::get_if<ProbeCommand>(&command);
  if (probe != nullptr) asked_ = *probe;
  MappingProcess* other = probe != nullptr ? what_if_->shown_process(context) : nullptr;
  if (other != nullptr)
    other->Post(command);
  else if (process_ != nullptr)
    process_->Post(command);
}

void InspectWorkspace::FocusTruth(const FrameContext& context) {
  if (context.sequence == nullptr) return;
  for (const SequenceView::Truth& truth : context.sequence->truth) {
    if (truth.id != context.selection.truth) continue;
    for (const ModelView& model : context.sequence->models) {
      if (model.name != truth.model) continue;
      const double size_m = model.bounds.isEmpty() ? 1.0 : model.bounds.diagonal().norm();
      scene_->FocusPlace(truth.world_from_object * (truth.scale * model.center),
                         truth.scale * size_m);
    }
  }
}

void InspectWorkspace::Handle(const ViewCommand& command, FrameContext& context) {
  std::visit(Overloaded{[&](const FocusSelectionCommand&) {
                          if (context.selection.object.value > 0)
                            scene_->FocusObject(context.selection.object);
                          else
                            FocusTruth(context);
                        },
                        [&](const ResetViewCommand&) {
                          context.follow = context.look_through = false;
                          viewport_ = {};
                          scene_->Reset();
                        },
                        [&](const ViewDirectionCommand& c) {
                          context.follow = context.look_through = false;
                          scene_->SetDirection(c.azimuth_rad, c.elevation_rad);
                        }},
             command);
}

void InspectWorkspace::Handle(const InspectCommand& command, FrameContext& context) {
  const auto forget_bookmark = [&](int frame) {
    std::erase_if(context.bookmarks, [&](const Bookmark& b) { return b.frame == frame; });
  };
  std::visit(
      Overloaded{
          [&](const SelectObjectCommand& c) {
            context.selection = {};
            context.selection.object = c.object;
            auto_select_ = false;
          },
          [&](const SelectTruthCommand& c) {
            context.selection = {};
            context.selection.truth = c.truth;
            auto_select_ = false;
          },
          [&](const SelectParticleCommand& c) { SelectParticle(c.particle, context); },
          [&](const HoverParticleCommand& c) { HoverParticle(c.particle, context); },
          [&](const SelectHypothesisCommand& c) { context.selection.hypothesis = c.hypothesis; },
          [&](const FollowCommand& c) { context.follow = c.follow; },
          [&](const LookThroughCommand& c) { context.look_through = c.on; },
          [&](const BookmarkCommand& c) {
            forget_bookmark(c.frame);
            context.bookmarks.push_back({c.frame, c.note});
            KeepBookmarks(context);
          },
          [&](const RemoveBookmarkCommand& c) {
            forget_bookmark(c.frame);
            KeepBookmarks(context);
          },
          [&](const AskFrameCommand&) { ask_frame_ = true; },
          [&](const ImageViewsCommand& c) { views_->SetCount(c.count, context); },
          [&](const PlaceViewCommand& c) { views_->Place(c.view, c.panel); },
          [&](const ShowPanelCommand& c) { ShowPanel(c.panel); },
          [&](const NeedCommand& c) {
            switch (c.what) {
              case NeedCommand::What::kObjectHistory:
                needed_.history = true;
                break;
              case NeedCommand::What::kRelations:
                needed_.relations = true;
                break;
              case NeedCommand::What::kOtherEdges:
                needed_.edges = c.edges;
                break;
              case NeedCommand::What::kScoreMap:
                needed_.score_map = true;
                break;
              case NeedCommand::What::kTimings:
                needed_.timings = true;
                break;
            }
          },
          [&](const PresentCommand& c) { Present(c.on, context); },
          [&](const AskForkCommand& c) {
            // The frame that it forks from stays the one that shows.
            if (c.show && context.playback->state == PlaybackState::kPlaying)
              window_.Post(PauseCommand{});
            what_if_->OfferFork(context);
            fork_sheet_.Open(context, c.show);
          },
          [&](const AskOptionsCommand& c) { fork_sheet_.OpenOptions(context, c.show); },
          [&](const AskNetworksCommand& c) {
            networks_sheet_.Open(c.show);
            networks_.Look();
          },
          [&](const FetchNetworkCommand& c) { networks_.Fetch(c.name); },
          [&](const StopFetchingCommand&) { networks_.StopFetching(); },
          [&](const LookAtNetworkCommand& c) { LookAtNetwork(c.file); },
          [&](const UseNetworksCommand& c) { Reopen(c, context); },
          [&](const FindPosesCommand&) {
            with_.find_poses = true;
            Begin(std::make_unique<MappingProcess>(options_.opener(source_, with_), std::nullopt,
                                                   wake_),
                  context);
          },
          [&](const ForkCommand& c) { what_if_->Fork(c, context); },
          [&](const CancelForkCommand&) { what_if_->CancelFork(); },
          [&](const CompareRunCommand& c) { what_if_->Compare(c.run, context); },
          [&](const FocusModeCommand& c) { FocusMode(c.mode, context); },
          [&](const ConfirmedOnlyCommand& c) { context.confirmed_only = c.on; },
          [&](const MaximizePanelCommand& c) {
            context.maximized = c.panel == context.maximized ? "" : c.panel;
            if (!context.maximized.empty()) {
              context.hidden_panels.erase(c.panel);
              ShowPanel(c.panel);
            }
          },
          [&](const HidePanelCommand& c) { HidePanel(c, context); },
          [&](const ChooseLayoutCommand& c) {
            if (const auto found = arrangements_.Find(c.name)) Arrange(*found, context);
          },
          [&](const KeepLayoutCommand& c) {
            const bool kept =
                arrangements_.Keep(c.name, {ratios_, context.image_views, context.hidden_panels});
            window_.Post(NoteCommand{kept ? "Kept as layout " + c.name
                                          : "A layout of one's own needs a name of its own"});
            context.own_layouts = arrangements_.own_names();
          },
          [&](const ForgetLayoutCommand& c) {
            arrangements_.Forget(c.name);
            context.own_layouts = arrangements_.own_names();
          },
          [&](const ShowRunCommand& c) {
            if (context.other != nullptr) context.run_shown = c.shown;
          }},
      command);
}

void InspectWorkspace::SelectParticle(int particle, FrameContext& context) {
  context.selection.particle = particle;
  context.selection.hypothesis = particle >= 0 ? kParticleHypothesis : 0;
  if (particle >= 0)
    Handle(ProbeCommand{context.selection.object, particle, asked_.reference, asked_.maps},
           context);
}

/// Asks for its outline, one question at a time.
void InspectWorkspace::HoverParticle(int particle, FrameContext& context) {
  hovered_now_ = particle;
  const ProbeView* known = context.probe.get();
  const bool answered = known == nullptr || known->hovered == asked_.hovered ||
                        known->object != asked_.object || !known->message.empty();
  const bool shown = known != nullptr && known->hovered == particle &&
                     known->object == context.selection.object && context.snapshot != nullptr &&
                     known->frame == context.snapshot->report.frame;
  if (particle < 0 || shown || !answered || asked_.reference || process_ == nullptr ||
      context.playback->state == PlaybackState::kPlaying)
    return;
  ProbeCommand ask = asked_;
  ask.object = context.selection.object;
  ask.particle = context.selection.particle;
  ask.hovered = particle;
  Handle(ask, context);
}

void InspectWorkspace::ShowPanel(const std::string& id) {
  const auto bring_up = [&](PanelPlace place, std::size_t& tab) {
    const std::vector<Panel*> tabs = PanelsAt(place);
    for (std::size_t i = 0; i < tabs.size(); ++i) {
      if (id == tabs[i]->id()) tab = i;
    }
  };
  bring_up(PanelPlace::kAboutMap, map_tab_);
  bring_up(PanelPlace::kAboutObject, object_tab_);
  for (const PanelPlace place :
       {PanelPlace::kAboutMap, PanelPlace::kAboutObject, PanelPlace::kTimings}) {
    for (const Panel* panel : PanelsAt(place)) {
      if (id == panel->id()) compact_tab_ = id;
    }
  }
}

void InspectWorkspace::Arrange(const Arrangement& arrangement, FrameContext& context) {
  ratios_ = arrangement.ratios;
  views_->SetCount(arrangement.image_views, context);
  context.hidden_panels = arrangement.hidden;
  context.maximized.clear();
}

void InspectWorkspace::HidePanel(const HidePanelCommand& command, FrameContext& context) const {
  for (const PanelEntry& entry : InspectPanels()) {
    if (command.panel != entry.info.id || !CanHide(entry)) continue;
    if (!command.hide)
      context.hidden_panels.erase(command.panel);
    else
      context.hidden_panels.insert(command.panel);
    if (context.maximized == command.panel) context.maximized.clear();
  }
}

/// Of the hypotheses with the mode's shape: the one whose place and azimuth are nearest to it, in
/// units of the mode's spread.
void InspectWorkspace::FocusMode(int mode, FrameContext& context) {
  const ObjectReport* object = context.SelectedObject();
  if (object == nullptr || mode < 0 || mode >= static_cast<int>(object->modes.size())) return;
  const PoseMode& of = object->modes[static_cast<std::size_t>(mode)];
  const ModelView* model = context.Model(of.label);
  const Eigen::Vector3d center =
      of.world_from_object *
      (of.scale * (model != nullptr ? model->center : Eigen::Vector3d(0, 0, 0)));
  const UprightFrame upright(-context.sequence->up_in_world);
  const Eigen::Vector3d front = of.world_from_object.linear().col(0);
  int nearest = -1;
  double least = 0;
  for (std::size_t i = 0; object->particles != nullptr && i < object->particles->size(); ++i) {
    const Particle& particle = (*object->particles)[i];
    if (particle.label != of.label.value) continue;
    const ParticlePlace place = PlaceOf(particle, *object, upright);
    const double turned = model != nullptr && model->any_azimuth
                              ? 0.0
                              : std::acos(std::clamp(front.dot(place.heading_in_world), -1.0, 1.0));
    const double far = (place.center_in_world - center).squaredNorm() /
                           std::pow(std::max(of.position_std_m, 0.005), 2) +
                       std::pow(turned / std::max(of.azimuth_std_rad, 0.01), 2);
    if (nearest >= 0 && far >= least) continue;
    nearest = static_cast<int>(i);
    least = far;
  }
  if (nearest >= 0) SelectParticle(nearest, context);
  const double size_m = model != nullptr && model->mesh != nullptr
                            ? BoundingBox(*model->mesh).diagonal().norm()
                            : 1.0;
  context.look_through = context.follow = false;
  scene_->FocusPlace(center, size_m);
}

void InspectWorkspace::Present(bool on, FrameContext& context) {
  if (on && (context.sequence == nullptr || context.workspace != WorkspaceId::kInspect)) return;
  window_.Post(FullScreenCommand{on});
  if (on)
    presenter_.Start(context, panels_, window_);
  else
    presenter_.Stop(context, panels_, window_);
}

void InspectWorkspace::AddBookmarksRead(FrameContext& context) {
  if (auto read = bookmarks_.TakeRead()) {
    // Those that were set meanwhile stand.
    std::erase_if(*read, [&](const Bookmark& old) {
      return std::any_of(context.bookmarks.begin(), context.bookmarks.end(),
                         [&](const Bookmark& b) { return b.frame == old.frame; });
    });
    context.bookmarks.insert(context.bookmarks.end(), read->begin(), read->end());
    bookmarks_known_ = true;
    if (std::exchange(bookmarks_changed_, false)) KeepBookmarks(context);
  }
  if (const auto problem = bookmarks_.TakeProblem())
    window_.Post(NoteCommand{"The bookmarks are not kept: " + problem->message});
}

void InspectWorkspace::KeepBookmarks(FrameContext& context) {
  std::sort(context.bookmarks.begin(), context.bookmarks.end(),
            [](const Bookmark& a, const Bookmark& b) { return a.frame < b.frame; });
  if (!bookmarks_known_) {
    bookmarks_changed_ = true;
    return;
  }
  std::vector<std::filesystem::path> files;
  if (auto file = BookmarkFile(context.source, options_.settings); !file.empty())
    files.push_back(std::move(file));
  // They belong to the run that the window is mapping, too, if that is kept.
  const std::string& run = context.playback->recording;
  if (!run.empty() && run != context.source && !IsTemporaryRun(run))
    files.push_back(BookmarkFile(run, {}));
  if (!files.empty()) bookmarks_.Write(std::move(files), context.bookmarks);
}

bool InspectWorkspace::Moves(const FrameContext& context) {
  return presenter_.active() || what_if_->TakeBlink(context);
}

Pace InspectWorkspace::pace(const FrameContext& context) const {
  if (presenter_.active()) return kPresentPace;
  return context.run_shown == RunShown::kBlink ? kBlinkPace : Pace();
}

}  // namespace plumbline
