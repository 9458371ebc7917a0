// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/sequence_writer.h"

#include <tbb/task_group.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <mutex>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/base/random.h"
#include "engine/base/timer.h"
#include "engine/dataset/json_fields.h"
#include "engine/dataset/proposals_file.h"
#include "engine/models/mesh_file.h"
#include "engine/synthetic/film.h"
#include "engine/synthetic/imu_simulator.h"
#include "engine/synthetic/ray_tracer.h"
#include "engine/synthetic/room.h"
#include "engine/synthetic/room_files.h"
#include "engine/synthetic/shutter.h"
#include "engine/synthetic/simulated_detector.h"
#include "engine/synthetic/synthetic_edges.h"
#include "engine/synthetic/track_simulator.h"
#include "engine/synthetic/walk.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;

/// Instances count as visible in a frame from so many pixels of a 960x500 image on.
constexpr double kVisiblePixels = 800;
constexpr double kFarthestDepth_m = 65.5;  ///< In 16-bit millimetres.
constexpr std::array<const char*, 6> kFolders = {"color", "edges", "proposals",
                                                 "depth", "masks", "models"};
/// Of a street: the very shapes that stand there, and the truth that names them.
constexpr const char* kRight = "right";
/// Written only on request; those of an earlier sequence must not stay.
constexpr std::array<const char*, 8> kFiles = {"imu.csv",    "imu.json",         "groundtruth.csv",
                                               "tracks.csv", "trajectory.txt",   "visibility.csv",
                                               "scene.ply",  "ground_truth.json"};

/// From here on scene.json marks the folder as ours, also if the program is killed.
Status PrepareFolder(const fs::path& folder, const SyntheticOptions& options) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_empty(folder, error)) {
    if (!fs::exists(folder / "scene.json")) {
      return Error{
          ErrorCode::kInvalidInput,
          "'" + folder.string() + "' holds other files; give an empty or a new folder with --out"};
    }
    for (const char* name : kFolders) fs::remove_all(folder / name, error);
    fs::remove_all(folder / kRight, error);
    for (const char* name : kFiles) fs::remove(folder / name, error);
  }
  fs::create_directories(folder, error);
  for (const char* name : kFolders) {
    if (options.tracks_only) break;
    fs::create_directories(folder / name, error);
    if (error)
      return Error{ErrorCode::kIo,
                   "cannot make '" + (folder / name).string() + "': " + error.message()};
  }
  return WriteJson(folder / "scene.json",
                   {{"scene", NameOf(options.scene)}, {"seed", options.seed}, {"frames", 0}});
}

std::string FrameName(int frame) {
  std::array<char, 16> text;
  std::snprintf(text.data(), text.size(), "%06d", frame);
  return text.data();
}

Status WriteImage(const fs::path& file, const cv::Mat& image, int jpeg_quality) {
  const std::vector<int> parameters = file.extension() == ".jpg"
                                          ? std::vector<int>{cv::IMWRITE_JPEG_QUALITY, jpeg_quality}
                                          : std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 2};
  try {
    if (cv::imwrite(file.string(), image, parameters)) return {};
  } catch (const cv::Exception&) {  // reported below
  }
  return Error{ErrorCode::kIo, "cannot write '" + file.string() + "'; is the disk full?"};
}

/// Runs of frames, both ends included: [[first, last], ...].
class FrameRuns {
 public:
  void Add(int frame) {
    if (!runs_.empty() && runs_.back().second == frame - 1) {
      runs_.back().second = frame;
    } else {
      runs_.emplace_back(frame, frame);
    }
  }
  nlohmann::json ToJson(int shortest) const {
    nlohmann::json list = nlohmann::json::array();
    for (const auto& [first, last] : runs_) {
      if (last - first + 1 >= shortest) list.push_back({first, last});
    }
    return list;
  }

 private:
  std::vector<std::pair<int, int>> runs_;
};

struct InstanceHistory {
  FrameRuns visible, hidden, truncated;
};

constexpr const char* kTrajectoryHeader = "# timestamp tx ty tz qx qy qz qw (world_from_cam)\n";

std::string TrajectoryRow(double t_s, const Isometry3d& world_from_cam) {
  const Eigen::Quaterniond q(world_from_cam.linear());
  const Eigen::Vector3d t = world_from_cam.translation();
  std::array<char, 256> line;
  std::snprintf(line.data(), line.size(), "%.9f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", t_s,
                t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  return line.data();
}

Status WriteGravity(const fs::path& folder, const SyntheticOptions& options, const Room& room) {
  const Eigen::Vector3d up = options.world_from_room.linear().col(2);
  const double offset = -up.dot(options.world_from_room.translation());
  nlohmann::json json = {{"gravity", {-up.x(), -up.y(), -up.z()}}};
  if (room.camera_height_m) {
    json["camera_height_m"] = *room.camera_height_m;
  } else {
    json["floor"] = {up.x(), up.y(), up.z(), offset};
  }
  for (const FloorLevel& level : room.levels) {
    nlohmann::json outline = nlohmann::json::array();
    for (const Eigen::Vector3d& corner : level.outline_in_world) {
      const Eigen::Vector3d in_world = options.world_from_room * corner;
      outline.push_back({in_world.x(), in_world.y(), in_world.z()});
    }
    json["levels"].push_back({{"height_m", level.height_m}, {"outline", std::move(outline)}});
  }
  return WriteJson(folder / "gravity.json", json);
}

/// What the IMU and the camera's place really are, for scene.json.
nlohmann::json ImuToJson(const ImuSimulation& imu, const BodyPath& path, int frames,
                         double rate_hz) {
  double length = 0;
  for (int frame = 1; frame < frames; ++frame)
    length += (path.RoomFromBody(frame / rate_hz).translation() -
               path.RoomFromBody((frame - 1) / rate_hz).translation())
                  .norm();
  return {{"body_from_cam", IsometryToJson(SyntheticBodyFromCam())},
          {"time_offset_s", imu.time_offset_s},
          {"noise", imu.noise},
          {"rest_s", imu.rest_s},
          {"tremor", imu.tremor},
          {"path_m", length}};
}

/// imu.csv, imu.json, groundtruth.csv and camera.json.
Status WriteMotion(const fs::path& folder, const SyntheticOptions& options, const BodyPath& path) {
  std::vector<std::int64_t> stamps;
  for (int frame = 0; frame < options.frames; ++frame)
    stamps.push_back(std::llround(frame / options.rate_hz * 1e9));
  const Status status = WriteImuFiles(
      folder, SimulateImu(path, options.world_from_room, stamps, *options.imu, options.seed));
  if (!status.ok()) return status;
  return WriteJson(folder / "camera.json", CameraToJson(StatedCamera(SyntheticCamera(options),
                                                                     *options.imu, options.seed)));
}

/// One frame on its way to the disk.
struct FramePictures {
  Shutter shutter;
  cv::Mat radiance;
  SurfaceMaps maps;
};

class SequenceJob {
 public:
  SequenceJob(const SyntheticOptions& options, const fs::path& folder, Room room, Walk walk,
              std::unique_ptr<const RayTracer> tracer)
      : options_(options),
        folder_(folder),
        room_(std::move(room)),
        walk_(std::move(walk)),
        tracer_(std::move(tracer)),
        camera_(SyntheticCamera(options)),
        meter_(room_),
        detector_(room_, FlawsOf(options), options.seed),
        history_(room_.instances.size()) {
    if (options.imu)
      path_.emplace(
          PathOfBody(walk_, *options.imu, options.seed, options.frames / options.rate_hz));
  }

  Status WriteStill();
  Status WriteFrames(const WorkContext& context);
  Status WriteTruth(int frames);

 private:
  FramePictures Render(int frame) const;
  Isometry3d RoomFromCam(double t_s) const {
    return path_ ? path_->RoomFromBody(t_s) * SyntheticBodyFromCam() : walk_.RoomFromCam(t_s);
  }
  double ExposureSeconds(int frame) const {
    const double walked = options_.imu
                              ? TimeAfterRest(frame / options_.rate_hz, options_.imu->rest_s)
                              : frame / options_.rate_hz;
    return walk_.ExposureSeconds(static_cast<int>(std::lround(walked * options_.rate_hz)));
  }
  int SamplesFor(const Shutter& shutter) const;
  Status WriteFrame(int frame, const FramePictures& pictures);
  void Remember(int frame, const Visibility& visibility);
  nlohmann::json InstanceToJson(std::size_t i) const;
  nlohmann::json MovingToJson(std::size_t i, int frames) const;

  const SyntheticOptions& options_;
  fs::path folder_;
  Room room_;
  Walk walk_;
  std::optional<BodyPath> path_;
  std::unique_ptr<const RayTracer> tracer_;
  Camera camera_;
  VisibilityMeter meter_;
  SimulatedDetector detector_;
  std::vector<InstanceHistory> history_;
  std::string trajectory_ = kTrajectoryHeader;
  std::string visibility_ = "frame,instance_id,pixels\n";
};

Status SequenceJob::WriteStill() {
  Status status = path_ ? WriteMotion(folder_, options_, *path_)
                        : WriteJson(folder_ / "camera.json", CameraToJson(camera_));
  if (!status.ok()) return status;
  status = WriteGravity(folder_, options_, room_);
  if (!status.ok()) return status;
  status = WriteModels(folder_ / "models", room_.catalogue);
  if (!status.ok()) return status;
  if (!room_.right_catalogue.empty()) {
    std::error_code error;
    fs::create_directories(folder_ / kRight / "models", error);
    status = WriteModels(folder_ / kRight / "models", room_.right_catalogue);
    if (!status.ok()) return status;
  }
  return WritePly(
      folder_ / "scene.ply",
      Transformed(ScanOfRoom(room_, *tracer_, room_.scan_spacing_m), options_.world_from_room));
}

/// More samples where the picture moves during the exposure, so that blur stays smooth.
int SequenceJob::SamplesFor(const Shutter& shutter) const {
  const std::vector<Isometry3d> poses = shutter.Exposure(0.5 * (camera_.pinhole.height - 1));
  const Isometry3d motion = poses.front().inverse() * poses.back();
  const double usual_m = IsStreet(options_.scene) ? 8 : 2;  // distance of what is seen
  const double moved = camera_.pinhole.fx * (Eigen::AngleAxisd(motion.linear()).angle() +
                                             motion.translation().norm() / usual_m);
  return std::clamp(static_cast<int>(std::lround(moved)), options_.samples_per_pixel,
                    4 * options_.samples_per_pixel);
}

FramePictures SequenceJob::Render(int frame) const {
  const Shutter shutter([this](double t_s) { return RoomFromCam(t_s); }, frame / options_.rate_hz,
                        ExposureSeconds(frame), camera_);
  return {shutter,
          tracer_->Photograph(camera_.pinhole, shutter, SamplesFor(shutter), options_.seed, frame),
          tracer_->Look(camera_.pinhole, shutter)};
}

void SequenceJob::Remember(int frame, const Visibility& visibility) {
  const double area =
      static_cast<double>(camera_.pinhole.width) * camera_.pinhole.height / (960.0 * 500.0);
  for (std::size_t i = 0; i < history_.size(); ++i) {
    const int pixels = visibility.pixels[i];
    if (pixels > 0)
      visibility_ +=
          std::to_string(frame) + "," + room_.instances[i].id + "," + std::to_string(pixels) + "\n";
    const bool visible = pixels > kVisiblePixels * area;
    if (visible) history_[i].visible.Add(frame);
    if (visible && visibility.truncated[i]) history_[i].truncated.Add(frame);
    if (visibility.share[i] >= 0 && visibility.share[i] < 0.15) history_[i].hidden.Add(frame);
  }
}

Status SequenceJob::WriteFrame(int frame, const FramePictures& pictures) {
  const std::string name = FrameName(frame);
  const FilmOptions film{tracer_->exposure(), options_.noise_levels};
  const cv::Mat picture = DevelopFilm(pictures.radiance, film);
  const SurfaceMaps& maps = pictures.maps;
  cv::Mat depth_mm;
  maps.depth.convertTo(depth_mm, CV_16U, 1000);
  depth_mm.setTo(0, maps.depth > kFarthestDepth_m);
  const EdgeMap edges = DetectSyntheticEdges(camera_.pinhole, maps, picture,
                                             options_.flawless ? EdgeFlaws{0, 0, 0} : EdgeFlaws(),
                                             options_.seed, frame);
  const Visibility visibility = meter_.Measure(camera_.pinhole, pictures.shutter, maps);
  const std::vector<Detection> found =
      detector_.Detect(frame, camera_.pinhole, pictures.shutter, maps, visibility);
  Remember(frame, visibility);

  const Isometry3d world_from_cam = options_.world_from_room * pictures.shutter.middle();
  trajectory_ += TrajectoryRow(frame / options_.rate_hz, world_from_cam);

  const std::string image_name = name + ".jpg";
  const std::array<std::pair<fs::path, cv::Mat>, 5> files = {
      {{folder_ / "color" / image_name, ExposeSensor(picture, film, options_.seed, frame)},
       {folder_ / "edges" / (name + ".png"), edges.probability},
       {folder_ / "edges" / (name + "_angle.png"), edges.angle},
       {folder_ / "depth" / (name + ".png"), depth_mm},
       {folder_ / "masks" / (name + ".png"), maps.instance}}};
  for (const auto& [file, image] : files) {
    const Status written = WriteImage(file, image, options_.jpeg_quality);
    if (!written.ok()) return written;
  }
  return WriteJson(folder_ / "proposals" / (name + ".json"),
                   nlohmann::json::array({ProposalsToJson(image_name, found)}));
}

/// Renders one frame while the one before is measured, encoded and written.
Status SequenceJob::WriteFrames(const WorkContext& context) {
  tbb::task_group writing;
  Status status;
  int frame = 0;
  for (; frame < options_.frames && !context.stop.stop_requested(); ++frame) {
    context.report({"frames", frame, options_.frames});
    FramePictures pictures = Render(frame);
    writing.wait();
    if (!status.ok()) return status;
    writing.run([this, frame, &status, pictures = std::move(pictures)] {
      status = WriteFrame(frame, pictures);
    });
  }
  writing.wait();
  if (!status.ok()) return status;
  status = WriteTruth(frame);
  if (!status.ok()) return status;
  if (frame < options_.frames) {
    return Error{ErrorCode::kCancelled, "stopped after " + std::to_string(frame) + " of " +
                                            std::to_string(options_.frames) + " frames; '" +
                                            folder_.string() +
                                            "' holds a complete, shorter sequence"};
  }
  context.report({"frames", frame, options_.frames});
  return {};
}

nlohmann::json SequenceJob::InstanceToJson(std::size_t i) const {
  const RoomInstance& instance = room_.instances[i];
  nlohmann::json json = {
      {"id", instance.id},
      {"model", instance.model},
      {"category", instance.category},
      {"world_from_object", IsometryToJson(options_.world_from_room * instance.room_from_object)},
      {"quality", "fine"},
      {"position_std_m", 0},
      {"azimuth_std_deg", 0},
      {"mask_id", i + 1},
      {"visible_frames", history_[i].visible.ToJson(1)}};
  if (instance.scale != 1) json["scale"] = instance.scale;
  if (instance.size_m)
    json["size_m"] = {instance.size_m->x(), instance.size_m->y(), instance.size_m->z()};
  return json;
}

nlohmann::json SequenceJob::MovingToJson(std::size_t i, int frames) const {
  const RoomInstance& instance = room_.instances[i];
  nlohmann::json poses = nlohmann::json::array();
  for (int frame = 0; frame < frames; ++frame) {
    const Isometry3d pose = instance.RoomFromObjectAt(frame / options_.rate_hz);
    poses.push_back(
        {{"frame", frame}, {"world_from_object", IsometryToJson(options_.world_from_room * pose)}});
  }
  return {{"id", instance.id},
          {"category", instance.category},
          {"size_m", {instance.size_m->x(), instance.size_m->y(), instance.size_m->z()}},
          {"mask_id", i + 1},
          {"visible_frames", history_[i].visible.ToJson(1)},
          {"poses", std::move(poses)}};
}

Status SequenceJob::WriteTruth(int frames) {
  nlohmann::json instances = nlohmann::json::array(), moving = nlohmann::json::array(),
                 situations = nlohmann::json::array();
  for (std::size_t i = 0; i < room_.instances.size(); ++i) {
    const RoomInstance& instance = room_.instances[i];
    if (instance.moves()) {
      moving.push_back(MovingToJson(i, frames));
      continue;
    }
    instances.push_back(InstanceToJson(i));
    situations.push_back({{"instance", instance.id},
                          {"hidden_frames", history_[i].hidden.ToJson(10)},
                          {"truncated_frames", history_[i].truncated.ToJson(10)}});
  }
  const Eigen::Vector3d up = options_.world_from_room.linear().col(2);
  nlohmann::json shaken = nlohmann::json::array();
  for (const auto& [first, last] : room_.walk.shaken_frames) {
    if (first < frames) shaken.push_back({first, std::min(last, frames) - 1});
  }
  nlohmann::json scene = {{"scene", NameOf(options_.scene)},
                          {"seed", options_.seed},
                          {"frames", frames},
                          {"room_size_m", {room_.size.x(), room_.size.y(), room_.size.z()}},
                          {"world_from_room", IsometryToJson(options_.world_from_room)},
                          {"situations", situations},
                          {"shaken_frames", shaken}};
  if (path_) scene["imu"] = ImuToJson(*options_.imu, *path_, frames, options_.rate_hz);
  if (room_.main_instance > 0)
    scene["main_instance"] = room_.instances[static_cast<std::size_t>(room_.main_instance - 1)].id;
  nlohmann::json truth = {{"gravity", {-up.x(), -up.y(), -up.z()}},
                          {"instances", std::move(instances)}};
  if (!moving.empty()) truth["moving"] = std::move(moving);
  Status status = WriteJson(folder_ / "ground_truth.json", truth);
  if (status.ok() && !room_.right_catalogue.empty()) {
    for (nlohmann::json& instance : truth["instances"])
      instance["model"] = room_.instances[instance["mask_id"].get<std::size_t>() - 1].right_model;
    status = WriteJson(folder_ / kRight / "ground_truth.json", truth);
  }
  if (status.ok()) status = WriteFileAtomically(folder_ / "trajectory.txt", trajectory_);
  if (status.ok()) status = WriteFileAtomically(folder_ / "visibility.csv", visibility_);
  if (status.ok()) status = WriteJson(folder_ / "scene.json", scene);
  return status;
}

/// Makes the models to be written larger or smaller than what they are models of.
void MisjudgeModels(const SyntheticOptions& options, Room& room) {
  if (options.model_error == 0) return;
  Random random({.seed = options.seed, .object = 0x53495a45});
  for (FurnitureModel& model : room.catalogue) {
    model.scale = 1 + (random.Uniform() < 0.5 ? 1 : -1) * options.model_error;
    for (RoomInstance& instance : room.instances) {
      if (instance.model == model.name) instance.scale = model.scale;
    }
  }
}

/// Follows points through the room without drawing it.
Result<SyntheticSummary> WriteTracks(const SyntheticOptions& options, const fs::path& folder,
                                     const Room& room, const Walk& walk,
                                     const WorkContext& context) {
  const Stopwatch timer;
  const BodyPath path =
      PathOfBody(walk, *options.imu, options.seed, options.frames / options.rate_hz);
  const TracedScene scene(StillParts(room));
  const Camera camera = SyntheticCamera(options);
  TrackSimulator simulator(scene, camera.pinhole, {}, options.seed);
  std::string rows = "# t[s],id,u,v[px]\n", trajectory = kTrajectoryHeader;
  for (int frame = 0; frame < options.frames; ++frame) {
    if (context.stop.stop_requested())
      return Error{ErrorCode::kCancelled, "stopped; '" + folder.string() + "' holds no tracks"};
    context.report({"frames", frame, options.frames});
    const double t_s = frame / options.rate_hz;
    const Shutter shutter(
        [&](double at_s) { return path.RoomFromBody(at_s) * SyntheticBodyFromCam(); }, t_s, 0,
        camera);
    const TrackedImage image = simulator.Next(std::llround(t_s * 1e9), shutter);
    for (const TrackedPoint& point : image.points) {
      std::array<char, 96> row;
      std::snprintf(row.data(), row.size(), "%.9f,%lld,%.4f,%.4f\n", t_s,
                    static_cast<long long>(point.id), point.pixel.x(), point.pixel.y());
      rows += row.data();
    }
    trajectory += TrajectoryRow(t_s, options.world_from_room * shutter.middle());
  }
  context.report({"frames", options.frames, options.frames});
  Status status = WriteFileAtomically(folder / "tracks.csv", rows);
  if (status.ok()) status = WriteFileAtomically(folder / "trajectory.txt", trajectory);
  if (status.ok()) status = WriteGravity(folder, options, room);
  if (status.ok()) status = WriteMotion(folder, options, path);
  if (status.ok())
    status = WriteJson(folder / "scene.json",
                       {{"scene", NameOf(options.scene)},
                        {"seed", options.seed},
                        {"frames", options.frames},
                        {"imu", ImuToJson(*options.imu, path, options.frames, options.rate_hz)}});
  if (!status.ok()) return status.error();
  SyntheticSummary summary;
  summary.frames = options.frames;
  summary.frame_seconds = timer.Milliseconds() / 1000;
  return summary;
}

}  // namespace

Camera SyntheticCamera(const SyntheticOptions& options) {
  // Of a 960x500 image; other sizes see the same width of the room.
  const double scale = options.width / 960.0;
  Camera camera;
  camera.pinhole.width = options.width;
  camera.pinhole.height = options.height;
  const double focal =  // in an image of 960 px of width
      options.horizontal_fov_rad ? 480.0 / std::tan(0.5 * *options.horizontal_fov_rad) : 560.0;
  camera.pinhole.fx = focal * scale;
  camera.pinhole.fy = (focal + 1.5) * scale;
  camera.pinhole.cx = (960.0 / 2 - 0.5 + 7.3 + 0.5) * scale - 0.5;
  camera.pinhole.cy = 0.5 * options.height - 0.5 - 4.6 * scale;
  camera.rate_hz = options.rate_hz;
  camera.rolling_shutter_s = options.rolling_shutter_s;
  return camera;
}

Result<SyntheticSummary> WriteSyntheticSequence(const SyntheticOptions& options,
                                                const fs::path& folder,
                                                const WorkContext& context) {
  const std::vector<std::string> problems = options.Validate();
  if (!problems.empty())
    return Error{ErrorCode::kInvalidInput, "synthetic sequence: " + problems.front()};
  Result<Room> room = FurnishRoom(options);
  if (!room.ok()) return room.error();
  MisjudgeModels(options, *room);
  Result<Walk> walk = Walk::Plan(*room, options.seed, options.rate_hz);
  if (!walk.ok()) return walk.error();
  Status status = PrepareFolder(folder, options);
  if (!status.ok()) return status.error();
  if (options.tracks_only) return WriteTracks(options, folder, *room, *walk, context);
  SyntheticSummary summary;
  const Stopwatch light_timer;
  Result<std::unique_ptr<const RayTracer>> tracer =
      RayTracer::Create(*room, {options.light_rays, options.light_spacing}, context);
  if (!tracer.ok()) return tracer.error();
  summary.light_seconds = light_timer.Milliseconds() / 1000;
  summary.instances = static_cast<int>(room->instances.size());
  SequenceJob job(options, folder, std::move(*room), std::move(*walk), std::move(*tracer));
  status = job.WriteStill();
  if (!status.ok()) return status.error();
  const Stopwatch frame_timer;
  status = job.WriteFrames(context);
  if (!status.ok()) return status.error();
  summary.frames = options.frames;
  summary.frame_seconds = frame_timer.Milliseconds() / 1000;
  return summary;
}

}  // namespace plumbline
