// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/mapping_pipeline.h"

#include <limits>
#include <mutex>
#include <thread>

#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/base/queue.h"
#include "engine/base/timer.h"
#include "engine/dataset/growing_recording.h"
#include "engine/dataset/growing_sequence.h"
#include "engine/mapping/mapper.h"
#include "engine/mapping/option_changes.h"
#include "engine/mapping/rendered_scorer.h"
#include "engine/mapping/viewpoint_scorer.h"
#include "engine/pipeline/corrected_poses.h"
#include "engine/pipeline/frame_preparer.h"
#include "engine/pipeline/own_pose_sequence.h"
#include "engine/pipeline/pipeline_parts.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/sources/folder_source.h"
#include "engine/sources/live_pace.h"
#include "engine/sources/live_source.h"
#include "engine/sources/selected_frames.h"
#include "engine/vio/own_poses.h"
#include "engine/vision/edge_detector.h"
#include "engine/vision/edge_network.h"
#include "engine/vision/network.h"
#include "engine/vision/two_stage_detector.h"

namespace plumbline {
namespace {

constexpr std::size_t kFramesAhead = 4;
constexpr std::size_t kFramesAheadLive = 1;  ///< What waits here grows old.

Status CheckLive(const RunRecipe& recipe) {
  if (!recipe.live_speed) return {};
  if (!(*recipe.live_speed >= kSlowestLive && *recipe.live_speed <= kFastestLive)) {
    char text[120];
    std::snprintf(text, sizeof(text),
                  "a live run is played at %g to %g times the speed it has, not %g", kSlowestLive,
                  kFastestLive, *recipe.live_speed);
    return Error{ErrorCode::kInvalidInput, text};
  }
  if (recipe.poses.source == PoseSource::kVio && recipe.own_poses.loops == LoopUse::kCorrected) {
    return Error{ErrorCode::kInvalidInput,
                 "a live run cannot know poses that are corrected by later images; choose "
                 "--set-poses loops=causal (or off) with --poses vio"};
  }
  return {};
}

Result<std::filesystem::path> ModelsOf(const Sequence& sequence, const RunRecipe& recipe) {
  if (!recipe.models.empty()) return recipe.models;
  if (const auto own = sequence.models_folder()) return *own;
  return Error{ErrorCode::kInvalidInput,
               "'" + recipe.sequence.string() +
                   "' has no models of its own; name a folder of CAD models with --models"};
}

/// One past the last frame that may be selected, whether it is recorded yet or not.
int EndOf(const RunRecipe& recipe, const Sequence& sequence) {
  const int most = GrowingRecordingOf(GivenSequence(sequence)) != nullptr
                       ? std::numeric_limits<int>::max()
                       : sequence.num_frames();
  return std::min(recipe.frames.end.value_or(most), most);
}

/// The sequence with the poses that the recipe asks for. What else lacks is said before they are
/// estimated, which takes long.
/// @param given  Null: that of the recipe.
Result<std::shared_ptr<const Sequence>> OpenWithPoses(const RunRecipe& recipe,
                                                      const WorkContext& work,
                                                      std::shared_ptr<const Sequence> given,
                                                      std::shared_ptr<const OwnPoses> own_poses,
                                                      std::unique_ptr<OwnPoseFeed> feed) {
  const bool all_given = given != nullptr;
  SequenceOptions poses;
  if (recipe.poses.source == PoseSource::kTrajectory) poses.poses = recipe.poses.file;
  const bool follow = recipe.live_speed && recipe.poses.source == PoseSource::kVio && !all_given &&
                      IsBeingRecorded(recipe.sequence);
  if (!follow && !all_given && IsBeingRecorded(recipe.sequence)) {
    log::warn("'{}' is being recorded; what it has now is mapped (--live --poses vio follows it)",
              recipe.sequence.string());
  }
  if (follow && *recipe.live_speed != 1) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + recipe.sequence.string() +
                     "' is being recorded, at the speed of life; say --live without another"};
  }
  Result<std::shared_ptr<const Sequence>> sequence =
      all_given ? std::move(given)
                : (follow ? FollowRecording(recipe.sequence, work)
                          : OpenSequence(recipe.sequence, poses));
  if (!sequence.ok()) return sequence.error();
  if (!(*sequence)->has_images()) {
    return Error{ErrorCode::kInvalidInput, "'" + recipe.sequence.string() +
                                               "' has no images (there is no folder color/); "
                                               "objects are mapped from images"};
  }
  if (recipe.poses.source != PoseSource::kVio) {
    if (Status status = CheckHasPoses(**sequence, poses.poses); !status.ok()) return status.error();
    if ((*sequence)->gravity_in_world()) return sequence;
    return Error{ErrorCode::kInvalidInput,
                 "'" + recipe.sequence.string() +
                     "' has no gravity.json; objects stand upright, so the mapper needs gravity"};
  }
  if (feed != nullptr) return WithOwnPoses(*sequence, std::move(feed));
  const int end = EndOf(recipe, **sequence);
  if (own_poses != nullptr && static_cast<int>(own_poses->frames.size()) < end)
    own_poses = nullptr;  // of a live run that was stopped
  if (all_given && own_poses == nullptr) {
    return Error{ErrorCode::kInvalidInput,
                 "the poses of the visual-inertial filter (--poses vio) that another process gave "
                 "end before frame " +
                     std::to_string(end)};
  }
  if (own_poses == nullptr) {
    if (const auto models = ModelsOf(**sequence, recipe); !models.ok()) return models.error();
    if (recipe.live_speed) {
      auto estimator = OwnPoseEstimator::Create(*sequence, end, recipe.own_poses);
      if (!estimator.ok()) return estimator.error();
      return WithOwnPoses(*sequence, std::move(estimator).value());
    }
    Result<OwnPoses> estimated = EstimateOwnPoses(*sequence, end, recipe.own_poses, work);
    if (!estimated.ok()) return estimated.error();
    own_poses = std::make_shared<const OwnPoses>(std::move(estimated).value());
  }
  return WithOwnPoses(*sequence, std::move(own_poses));
}

/// Makes the recipe of what was opened complete: absolute paths, content hashes.
/// @param own_detector, own_edges  False: they were given, and what they are is told already.
Status Complete(const ModelDatabase& database, bool own_detector, bool own_edges,
                RunRecipe& recipe) {
  recipe.sequence = std::filesystem::absolute(recipe.sequence);
  recipe.models = std::filesystem::absolute(database.folder());
  const auto complete = [](auto& choice, auto hash_of) -> Status {
    if (choice.file.empty()) return {};
    choice.file = std::filesystem::absolute(choice.file);
    Result<std::string> hash = hash_of(choice.file);
    if (!hash.ok()) return hash.error();
    choice.hash = std::move(hash).value();
    return {};
  };
  if (Status status = complete(recipe.poses, HashFile); !status.ok()) return status;
  if (recipe.poses.source == PoseSource::kVio) recipe.poses.hash = HashOf(recipe.own_poses);
  if (own_detector) {
    if (recipe.detector->source == DetectorSource::kBuiltin)
      recipe.detector->hash = HashOfBuiltinDetector();
    if (Status status = complete(*recipe.detector, HashOfNetwork); !status.ok()) return status;
  }
  if (!own_edges) return {};
  if (recipe.edges->source == EdgeSource::kBuiltin ||
      recipe.edges->source == EdgeSource::kBuiltinHalf)
    recipe.edges->hash = HashOfBuiltinEdges(recipe.edges->source == EdgeSource::kBuiltinHalf);
  return complete(*recipe.edges, HashOfNetwork);
}

Result<std::shared_ptr<HypothesisScorer>> CreateScorer(
    ScorerKind kind, const std::shared_ptr<const ModelDatabase>& database,
    const WorkContext& work) {
  if (kind == ScorerKind::kRendered) {
    auto rendered = RenderedScorer::Create(database, {});
    if (!rendered.ok()) return rendered.error();
    return std::shared_ptr<HypothesisScorer>(std::move(rendered).value());
  }
  std::vector<std::shared_ptr<const ViewpointModel>> viewpoints;
  for (const CadModel& model : database->models()) {
    Result<std::shared_ptr<const ViewpointModel>> views =
        ViewpointModel::LoadOrBuild(model, ViewpointsOf(model), CacheDirectory(), work);
    if (!views.ok()) return views.error();
    viewpoints.push_back(*views);
  }
  return std::shared_ptr<HypothesisScorer>(
      std::make_shared<ViewpointScorer>(std::move(viewpoints), database));
}

}  // namespace

struct MappingPipeline::Impl {
  RunRecipe recipe;
  std::shared_ptr<const Sequence> sequence;
  std::shared_ptr<OwnPoseStore> own_poses;    ///< Null unless poses = vio.
  OwnPosesTaken taken;                        ///< By TakeGrownPoses.
  const GrowingRecording* growing = nullptr;  ///< Null: all frames are recorded.
  std::unique_ptr<RecordedSource> source;     ///< Next is called by the thread below alone.
  std::unique_ptr<SelectedFrames> wanted;     ///< Of `source`.
  std::unique_ptr<LiveSource> live;           ///< Of `wanted`; null: every frame is mapped.
  LivePace pace;                              ///< Of `live`.
  std::shared_ptr<const ModelDatabase> database;
  std::unique_ptr<FramePreparer> preparer;
  std::mutex preparer_mutex;
  std::unique_ptr<Mapper> mapper;
  std::shared_ptr<const HypothesisScorer> scorer;
  std::shared_ptr<CropComparer> crops;
  MapperOptions options;      ///< Of the next frame.
  MapperOptions mapped_with;  ///< Of the last frame.
  int options_version = 0;    ///< The preparer's, of `options`.
  /// Of a recording that grows those that have come, and the next where more may come.
  std::vector<int> selected;
  bool ended = false;  ///< Nothing more will come of a recording that grows.
  std::size_t next = 0;
  FrameReport last_report;  ///< A skipped frame leaves the map as it was.
  CorrectedPoses poses;
  std::unique_ptr<BoundedQueue<Prepared>> ahead;
  std::jthread thread;  ///< Last: stops before what it uses goes.

  /// The frames of the range that have come and, of a recording that grows, the next of them.
  void Select() {
    const bool expects = growing != nullptr && !ended;
    const int end = EndOf(recipe, *sequence), come = sequence->num_frames();
    const int step = recipe.frames.step;
    while (!selected.empty() && selected.back() >= come) selected.pop_back();
    for (int i = selected.empty() ? recipe.frames.begin : selected.back() + step; i < end;
         i += step) {
      if (i >= come && !expects) break;
      selected.push_back(i);
      if (i >= come) break;
    }
  }

  void StartAhead() {
    ahead = std::make_unique<BoundedQueue<Prepared>>(live ? kFramesAheadLive : kFramesAhead);
    source->Seek(selected[next]);
    thread = std::jthread([this](const std::stop_token& stop) {
      FrameSource& frames = live ? static_cast<FrameSource&>(*live) : *wanted;
      std::optional<FloorEstimate> floor;
      PoseNews news;  // since the frame before
      while (!live || pace.WaitToTake(stop)) {
        const std::optional<FramePacket> frame = NextFrame(frames, stop, floor, news);
        if (!frame) break;
        std::optional<PoseEstimate> pose;
        for (const auto& one : news) {
          const auto* estimate = std::get_if<PoseEstimate>(&one);
          if (estimate != nullptr && estimate->stamp_ns == frame->stamp_ns) pose = *estimate;
        }
        const auto began = LivePace::Clock::now();
        Prepared prepared = PrepareFrame(*frame, pose);
        pace.Made(LivePace::Clock::now() - began);
        prepared.floor = floor;
        prepared.news = std::exchange(news, {});
        if (!ahead->Push(std::move(prepared))) return;
      }
      ahead->Close();
    });
  }

  /// Reads on to the next frame; nothing at the end. What comes before it is put into the others.
  static std::optional<FramePacket> NextFrame(FrameSource& frames, const std::stop_token& stop,
                                              std::optional<FloorEstimate>& floor, PoseNews& news) {
    while (true) {
      const Result<std::optional<Packet>> packet = frames.Next(stop);
      if (!packet.ok() || !packet.value()) return std::nullopt;
      if (const auto* estimate = std::get_if<PoseEstimate>(&**packet)) news.push_back(*estimate);
      if (const auto* estimate = std::get_if<FloorEstimate>(&**packet)) floor = *estimate;
      if (const auto* found = std::get_if<PointEstimates>(&**packet)) news.push_back(*found);
      if (const auto* frame = std::get_if<FramePacket>(&**packet)) return *frame;
    }
  }

  Prepared PrepareFrame(const FramePacket& frame, const std::optional<PoseEstimate>& pose) {
    const std::lock_guard lock(preparer_mutex);
    const auto known = own_poses != nullptr ? own_poses->At(frame.frame) : std::nullopt;
    return preparer->Prepare(frame, pose, known ? known->waits_for : "");
  }
  /// Any frame of the source, again. Errors: why it cannot be used.
  Result<MapperInput> InputAgain(int frame) {
    Prepared prepared = PrepareFrame(source->Frame(frame), poses.Now(source->Pose(frame)));
    if (!prepared.input) return Error{ErrorCode::kCorrupt, prepared.skipped};
    return std::move(*prepared.input);
  }
  MapperSetup Setup() const {
    MapperSetup setup;
    setup.camera = sequence->camera();
    setup.gravity_in_world = *sequence->gravity_in_world();
    setup.floor_in_world = sequence->floor_in_world();
    setup.floor_std_m = sequence->floor_std_m();
    setup.floor_levels = sequence->floor_levels();
    if (own_poses != nullptr && own_poses->last_floor())
      setup.floor_std_m = own_poses->last_floor()->std_m;
    setup.database = database;
    setup.scorer = scorer;
    setup.crops = crops;
    setup.options = options;
    setup.seed = recipe.seed;
    return setup;
  }

  ~Impl() {
    if (ahead) ahead->Close();
  }

  void UseOptions(const MapperOptions& now) {
    options = now;
    mapper->SetOptions(now);
    const std::lock_guard lock(preparer_mutex);
    preparer->SetOptions(now);
    options_version = preparer->options_version();
  }

  static Result<std::unique_ptr<MappingPipeline>> Open(const RunRecipe& recipe,
                                                       const WorkContext& work, PipelineParts parts,
                                                       std::shared_ptr<const OwnPoses> own_poses);
  std::shared_ptr<MapSnapshot> Map(Prepared& prepared);
  /// The map as the last used frame left it.
  FrameReport Skip(const Prepared& prepared) const {
    FrameReport report = last_report;
    report.frame = prepared.frame.index;
    report.world_from_cam = prepared.frame.world_from_cam;
    report.skipped = prepared.skipped;
    report.skip_cause = prepared.skip_cause;
    report.proposals.clear();
    report.timings.clear();
    report.events = {{EventKind::kFrameSkipped, {}, {}, prepared.skipped, {}}};
    std::erase_if(report.objects,
                  [](const ObjectReport& object) { return object.state == ObjectState::kRetired; });
    for (ObjectReport& object : report.objects) object.updated = false;
    return report;
  }

  std::shared_ptr<MapSnapshot> Snapshot(FrameReport report, const Frame& frame,
                                        const EdgeMap& edges, const RenderedMaps& maps) const {
    auto snapshot = std::make_shared<MapSnapshot>();
    snapshot->report = std::move(report);
    snapshot->image = frame.image;
    snapshot->edge_probability = edges.probability;
    snapshot->edge_angle = edges.angle;
    snapshot->depth = maps.depth;
    snapshot->id = maps.id;
    return snapshot;
  }
};

MappingPipeline::MappingPipeline(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MappingPipeline::~MappingPipeline() = default;

Result<std::unique_ptr<MappingPipeline>> MappingPipeline::Open(
    const RunRecipe& recipe, const WorkContext& work, std::shared_ptr<const OwnPoses> own_poses) {
  return Impl::Open(recipe, work, {}, std::move(own_poses));
}

Result<std::unique_ptr<MappingPipeline>> MappingPipeline::OpenWith(PipelineParts parts,
                                                                   const RunRecipe& recipe,
                                                                   const WorkContext& work) {
  auto own_poses = std::move(parts.own_poses);
  return Impl::Open(recipe, work, std::move(parts), std::move(own_poses));
}

Result<std::unique_ptr<MappingPipeline>> MappingPipeline::Impl::Open(
    const RunRecipe& recipe, const WorkContext& work, PipelineParts parts,
    std::shared_ptr<const OwnPoses> own_poses) {
  if (Status status = CheckLive(recipe); !status.ok()) return status.error();
  auto impl = std::make_unique<Impl>();
  Result<std::shared_ptr<const Sequence>> sequence =
      OpenWithPoses(recipe, work, std::move(parts.sequence), std::move(own_poses),
                    std::move(parts.own_pose_feed));
  if (!sequence.ok()) return sequence.error();
  impl->sequence = *sequence;
  impl->own_poses = OwnPoseStoreOf(**sequence);
  if (impl->own_poses != nullptr) {
    impl->source = std::make_unique<OwnPoseSource>(*sequence);
  } else {
    impl->source = std::make_unique<FolderSource>(*sequence, false);
  }
  const Sequence& frames = *impl->sequence;
  const Result<std::filesystem::path> models = ModelsOf(frames, recipe);
  if (!models.ok()) return models.error();
  Result<std::shared_ptr<const ModelDatabase>> database = ModelDatabase::Load(*models);
  if (!database.ok()) return database.error();
  impl->database = *database;
  impl->recipe = recipe;
  const bool own_edges = parts.edges == nullptr, own_detector = parts.detector == nullptr;
  const bool cache = !recipe.live_speed;  // no camera gives an image that is known already
  if (own_detector) {
    parts.detector_choice = recipe.detector.value_or(DefaultDetector(frames));
    Result<std::unique_ptr<Detector>> detector =
        CreateDetector(ToText(parts.detector_choice), impl->sequence, {.cache = cache});
    if (!detector.ok()) return detector.error();
    parts.detector = std::move(detector).value();
  }
  if (own_edges) {
    parts.edge_choice = recipe.edges.value_or(DefaultEdges(frames));
    Result<std::unique_ptr<EdgeDetector>> edges =
        CreateEdgeDetector(ToText(parts.edge_choice), impl->sequence, {.cache = cache});
    if (!edges.ok()) return edges.error();
    parts.edges = std::move(edges).value();
  }
  impl->recipe.detector = parts.detector_choice;
  impl->recipe.edges = parts.edge_choice;
  if (Status status = Complete(**database, own_detector, own_edges, impl->recipe); !status.ok())
    return status.error();

  impl->growing = GrowingRecordingOf(GivenSequence(frames));
  impl->Select();
  if (impl->selected.empty()) {
    return Error{ErrorCode::kInvalidInput, "the range selects none of the " +
                                               std::to_string(frames.num_frames()) +
                                               " frames of '" + recipe.sequence.string() + "'"};
  }
  const FrameRange& range = recipe.frames;
  const int last = impl->growing != nullptr ? EndOf(recipe, frames) - 1 : impl->selected.back();
  impl->wanted = std::make_unique<SelectedFrames>(*impl->source, range.begin, last, range.step);
  if (impl->growing != nullptr) {
    impl->live = std::make_unique<LiveSource>(*impl->wanted, *impl->growing, range.step);
  } else if (recipe.live_speed) {
    impl->live = std::make_unique<LiveSource>(*impl->wanted, *recipe.live_speed);
  }

  Result<std::shared_ptr<HypothesisScorer>> scorer =
      CreateScorer(recipe.scorer, impl->database, work);
  if (!scorer.ok()) return scorer.error();
  impl->preparer = std::make_unique<FramePreparer>(
      std::move(parts.detector), std::move(parts.edges), recipe.options, frames.camera().fx);
  impl->scorer = *scorer;
  impl->crops = std::make_shared<CropComparer>(impl->database);
  impl->options = impl->mapped_with = recipe.options;
  MapperSetup setup = impl->Setup();
  if (impl->own_poses != nullptr) setup.floor_in_world.reset();  // known as it is found
  Result<std::unique_ptr<Mapper>> mapper = Mapper::Create(setup);
  if (!mapper.ok()) return mapper.error();
  impl->mapper = std::move(mapper).value();
  if (impl->own_poses != nullptr)  // with z up
    impl->poses = CorrectedPoses(LandmarkLoops(recipe.own_poses.closing));
  return std::unique_ptr<MappingPipeline>(new MappingPipeline(std::move(impl)));
}

const Sequence& MappingPipeline::sequence() const { return *impl_->sequence; }
std::shared_ptr<const Sequence> MappingPipeline::shared_sequence() const { return impl_->sequence; }
std::shared_ptr<const ModelDatabase> MappingPipeline::database() const { return impl_->database; }

std::shared_ptr<const OwnPoses> MappingPipeline::own_poses() const {
  return impl_->own_poses != nullptr ? impl_->own_poses->Copy() : nullptr;
}

std::shared_ptr<const OwnPoseGrowth> MappingPipeline::TakeGrownPoses(bool rest) {
  Impl& m = *impl_;
  if (m.own_poses == nullptr || !m.own_poses->grows()) return nullptr;
  return rest || m.next >= m.selected.size() ? m.taken.Rest(*m.own_poses)
                                             : m.taken.NowAndThen(*m.own_poses);
}

const LandmarkLoops* MappingPipeline::landmarks() const { return impl_->poses.loops(); }

const RunRecipe& MappingPipeline::recipe() const { return impl_->recipe; }
int MappingPipeline::end_frame() const { return impl_->selected.back() + 1; }
int MappingPipeline::num_done() const { return static_cast<int>(impl_->next); }
int MappingPipeline::num_selected() const { return static_cast<int>(impl_->selected.size()); }
void MappingPipeline::SetOptions(const MapperOptions& options) { impl_->UseOptions(options); }

bool MappingPipeline::grows() const { return impl_->growing != nullptr; }

std::optional<LiveReport> MappingPipeline::live() const {
  return impl_->live ? std::optional(impl_->live->report()) : std::nullopt;
}

std::optional<std::shared_ptr<MapSnapshot>> MappingPipeline::Next(const std::stop_token& stop) {
  Impl& m = *impl_;
  if (m.next >= m.selected.size()) return std::nullopt;
  if (!m.ahead) m.StartAhead();
  const std::stop_callback close(stop, [&m] { m.ahead->Close(); });
  m.pace.Asked();
  std::optional<Prepared> prepared = m.ahead->Pop();
  m.pace.Given();
  if (m.growing != nullptr) {
    m.ended = !prepared && !stop.stop_requested();
    m.Select();
    if (m.ended) m.next = m.selected.size();
  }
  if (!prepared) return std::nullopt;
  std::shared_ptr<MapSnapshot> snapshot = m.Map(*prepared);
  if (m.live) m.live->Done(prepared->frame.index);
  return snapshot;
}

std::shared_ptr<MapSnapshot> MappingPipeline::Impl::Map(Prepared& prepared) {
  while (next < selected.size() && selected[next] <= prepared.frame.index) ++next;
  std::vector<LifeEvent> events;
  if (std::string changes = OptionChanges(mapped_with, options); !changes.empty()) {
    std::string text = DescribeOptionChanges(changes);
    events.push_back({EventKind::kOptionsChanged, {}, {}, std::move(text), std::move(changes)});
  }
  mapped_with = options;
  const auto add_events = [&](FrameReport& report) {
    report.events.insert(report.events.begin(), events.begin(), events.end());
  };
  poses.Take(prepared.news, *mapper);
  poses.See(source->Pose(prepared.frame.index), prepared.input ? &*prepared.input : nullptr);
  if (prepared.input) prepared.frame.world_from_cam = prepared.input->world_from_cam;
  if (!prepared.input) {
    FrameReport report = Skip(prepared);
    add_events(report);
    return Snapshot(std::move(report), prepared.frame, prepared.edges, {});
  }
  if (prepared.options_version != options_version)  // made ready before they changed
    MakeTables(options, sequence->camera().fx, *prepared.input);
  if (own_poses != nullptr && prepared.floor)
    mapper->SetFloor(prepared.floor->floor_in_world, prepared.floor->std_m);
  FrameReport report = mapper->Step(*prepared.input);
  add_events(report);
  poses.CloseLoops(report, *mapper);
  report.timings.insert(report.timings.begin(), prepared.timings.begin(), prepared.timings.end());
  last_report = report;
  return Snapshot(std::move(report), prepared.frame, prepared.edges, mapper->mean_maps());
}

Status MappingPipeline::Resume(const FrameReport& report,
                               const std::optional<MapperOptions>& options,
                               const LandmarkHistory& landmarks) {
  Impl& m = *impl_;
  PLB_CHECK(m.next == 0 && !m.ahead) << "resume before the first frame";
  if (options) m.UseOptions(*options);
  m.mapped_with = m.options;
  while (m.next < m.selected.size() && m.selected[m.next] <= report.frame) ++m.next;
  m.last_report = report;
  if (m.own_poses != nullptr) m.own_poses->Advance(report.frame, {});
  // The report is of before its own landmarks corrected anything.
  LandmarkHistory before = landmarks;
  const bool corrects = before.erase(report.frame) > 0;
  if (m.own_poses != nullptr)
    m.poses = CorrectedPoses(ReplayLandmarks(m.sequence, m.recipe, report.frame, before));
  Status status = m.mapper->Restore(report, [&](int frame) { return m.InputAgain(frame); });
  if (status.ok() && corrects) m.poses.Add(landmarks.at(report.frame), *m.mapper);
  return status;
}

Status MappingPipeline::Plant(const PlantedObject& object) {
  const std::optional<ModelId> label = database()->Find(object.model);
  if (!label) {
    return Error{ErrorCode::kNotFound,
                 "the models of the run have no '" + object.model + "' that could be planted"};
  }
  if (impl_->options.filter == FilterKind::kPaper)
    return Error{ErrorCode::kUnsupported,
                 "nothing can be planted in a run of filter = paper; fork one of the default"};
  impl_->mapper->Plant(*label, object.world_from_object, object.scale, object.why);
  return {};
}

void MappingPipeline::LookBack(const LandmarkHistory& landmarks) {
  Impl& m = *impl_;
  if (m.own_poses == nullptr) return;
  m.poses = CorrectedPoses(ReplayLandmarks(m.sequence, m.recipe, m.selected.back(), landmarks));
}

std::optional<Eigen::Isometry3d> MappingPipeline::PoseInTheEnd(int frame) const {
  if (impl_->own_poses == nullptr) return std::nullopt;
  const auto known = impl_->poses.Now(impl_->source->Pose(frame));
  return known ? std::optional(known->world_from_cam) : std::nullopt;
}

Result<MapperInput> MappingPipeline::InputAgain(int frame) { return impl_->InputAgain(frame); }
MapperSetup MappingPipeline::setup() const { return impl_->Setup(); }

}  // namespace plumbline
