// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/kitti_raw_sequence.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "engine/base/files.h"
#include "engine/dataset/kitti_files.h"
#include "engine/dataset/kitti_tracklets.h"
#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/rigid_matrix.h"
#include "engine/dataset/stamped_rows.h"
#include "engine/sensor/image_file.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kOxtsStep_ns = 250'000'000;
constexpr double kParkedWithin_m = 1;
/// Of the cameras over the ground (Geiger et al., "Vision meets robotics: the KITTI dataset", IJRR
/// 2013, the figure of the car).
constexpr double kCameraHeight_m = 1.65;

fs::path RawFile(const fs::path& folder, std::size_t number, const char* ending) {
  char name[32];
  std::snprintf(name, sizeof name, "%010zu%s", number, ending);
  return folder / "data" / name;
}

fs::path ImagesOfKittiRaw(const fs::path& drive) {
  return drive / (IsThere(drive / "image_02" / "timestamps.txt") ? "image_02" : "image_00");
}

/// In the drive itself or the folder of the day.
fs::path CalibrationOf(const fs::path& drive, const char* name) {
  if (IsThere(drive / name)) return drive / name;
  const fs::path whole = fs::absolute(drive).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).parent_path() / name;
}

/// The rotation R and the translation T of a calibration file.
std::optional<Eigen::Isometry3d> RigidIn(const KittiCalibration& calibration) {
  const auto r = calibration.find("R"), t = calibration.find("T");
  if (r == calibration.end() || t == calibration.end() || r->second.size() != 9 ||
      t->second.size() != 3)
    return std::nullopt;
  std::vector<double> rows;
  for (std::size_t i = 0; i < 3; ++i) {
    rows.insert(rows.end(), r->second.begin() + static_cast<std::ptrdiff_t>(3 * i),
                r->second.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
    rows.push_back(t->second[i]);
  }
  return RigidFromRows(rows);
}

struct KittiRig {
  KittiCamera camera;
  std::string name;
  std::optional<Eigen::Isometry3d> cam_from_velo, cam_from_body;
};

Result<KittiRig> ReadKittiRig(const fs::path& drive) {
  KittiRig rig;
  rig.name = ImagesOfKittiRaw(drive).filename().string();
  const std::string number = rig.name.substr(6);  // of image_NN
  const fs::path file = CalibrationOf(drive, "calib_cam_to_cam.txt");
  Result<KittiCalibration> cameras = ParseKittiCalibration(file);
  if (!cameras.ok()) return cameras.error();
  const std::vector<double> size = (*cameras)["S_rect_" + number], turn = (*cameras)["R_rect_00"];
  if (size.size() != 2 || turn.size() != 9 || !(size[0] > 0 && size[0] < 65536) ||
      !(size[1] > 0 && size[1] < 65536))
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' needs S_rect_" + number +
                                          ", R_rect_00 and P_rect_" + number};
  Result<KittiCamera> camera = CameraFromProjection(
      (*cameras)["P_rect_" + number], static_cast<int>(size[0]), static_cast<int>(size[1]), file);
  if (!camera.ok()) return camera.error();
  rig.camera = std::move(*camera);
  const fs::path velo_file = CalibrationOf(drive, "calib_velo_to_cam.txt"),
                 imu_file = CalibrationOf(drive, "calib_imu_to_velo.txt");
  if (!IsThere(velo_file)) return rig;
  const Result<KittiCalibration> velo = ParseKittiCalibration(velo_file);
  if (!velo.ok()) return velo.error();
  const std::optional<Eigen::Isometry3d> unrectified_from_velo = RigidIn(*velo);
  const std::optional<Eigen::Isometry3d> rectified = RigidFromRows(std::vector<double>{
      turn[0], turn[1], turn[2], 0, turn[3], turn[4], turn[5], 0, turn[6], turn[7], turn[8], 0});
  if (!unrectified_from_velo || !rectified)
    return Error{ErrorCode::kCorrupt,
                 "'" + velo_file.string() + "' or R_rect_00 is no rigid transform R, T"};
  rig.cam_from_velo = rig.camera.cam_from_cam0 * *rectified * *unrectified_from_velo;
  if (!IsThere(imu_file)) return rig;
  const Result<KittiCalibration> imu = ParseKittiCalibration(imu_file);
  if (!imu.ok()) return imu.error();
  const std::optional<Eigen::Isometry3d> velo_from_body = RigidIn(*imu);
  if (!velo_from_body)
    return Error{ErrorCode::kCorrupt, "'" + imu_file.string() + "' is no rigid transform R, T"};
  rig.cam_from_body = *rig.cam_from_velo * *velo_from_body;
  rig.camera.camera.body_from_cam = rig.cam_from_body->inverse();
  return rig;
}

struct StampedPacket {
  std::int64_t stamp_ns = 0;
  std::size_t number = 0;
  OxtsPacket packet;
};

Result<std::vector<StampedPacket>> ReadOxts(const fs::path& folder,
                                            std::vector<std::string>& warnings) {
  std::vector<StampedPacket> packets;
  const Result<std::vector<std::optional<std::int64_t>>> stamps =
      KittiStamps(folder / "timestamps.txt");
  if (!stamps.ok()) return stamps.error();
  int unusable = 0;
  std::string such;
  for (std::size_t i = 0; i < stamps->size(); ++i) {
    const fs::path file = RawFile(folder, i, ".txt");
    if (!IsThere(file)) continue;
    const Result<std::string> text = ReadFile(file);
    const auto packet = text.ok() ? ParseOxts(*text) : std::nullopt;
    if ((!packet || !(*stamps)[i]) && unusable++ == 0) such = file.filename().string();
    if (packet && (*stamps)[i]) packets.push_back({*(*stamps)[i], i, *packet});
  }
  if (unusable > 0)
    warnings.push_back("'" + folder.string() + "' has " + std::to_string(unusable) +
                       " packets that are not 30 numbers and a stamp (such as '" + such +
                       "'); left out");
  return packets;
}

void JoinOxts(const std::vector<StampedPacket>& packets, const Eigen::Isometry3d& body_from_cam,
              std::vector<RecordedFrame>& frames) {
  if (packets.empty()) return;
  const OxtsPacket& origin = packets.front().packet;
  std::map<std::size_t, Eigen::Isometry3d> by_number;
  Trajectory by_stamp;
  for (const StampedPacket& packet : packets) {
    const Eigen::Isometry3d pose = PoseOf(packet.packet, origin) * body_from_cam;
    by_number[packet.number] = pose;
    by_stamp.poses.push_back({packet.stamp_ns, pose});
  }
  // As many images as packets: they were synchronised by number.
  const bool synchronised = packets.back().number == frames.back().item;
  std::vector<std::string> ignored;
  MakeStampsRise({}, "packets", by_stamp.poses, ignored);
  for (RecordedFrame& frame : frames) {
    if (!synchronised) {
      frame.world_from_cam = PoseAt(by_stamp, frame.stamp_ns, kOxtsStep_ns);
    } else if (const auto pose = by_number.find(frame.item); pose != by_number.end()) {
      frame.world_from_cam = pose->second;
    }
  }
}

/// COCO's name for a type of KITTI.
std::string CategoryOfKitti(const std::string& type) {
  static const std::map<std::string, std::string> kCategories = {
      {"Car", "car"},        {"Van", "car"},           {"Truck", "truck"},
      {"Tram", "train"},     {"Pedestrian", "person"}, {"Person (sitting)", "person"},
      {"Cyclist", "bicycle"}};
  const auto found = kCategories.find(type);
  return found == kCategories.end() ? "misc" : found->second;
}

std::string NameOfType(const std::string& type) {
  std::string name;
  for (const char c : type) name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

/// Where it stands over its frames, in world; frames without a pose are passed over.
std::optional<GroundTruthInstance> ParkedInstance(
    const KittiTracklet& tracklet, const std::map<int, Eigen::Isometry3d>& world_from_velo,
    bool& moves) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), front = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < tracklet.places.size(); ++i) {
    const auto pose = world_from_velo.find(tracklet.first_frame + static_cast<int>(i));
    if (pose == world_from_velo.end()) continue;
    const KittiTracklet::Place& place = tracklet.places[i];
    positions.push_back(pose->second * place.position_in_velo);
    mean += positions.back();
    front += pose->second.linear() *
             Eigen::Vector3d(std::cos(place.yaw_rad), std::sin(place.yaw_rad), 0);
  }
  if (positions.empty()) return std::nullopt;
  mean /= static_cast<double>(positions.size());
  for (const Eigen::Vector3d& position : positions)
    moves = moves || (position - mean).norm() > kParkedWithin_m;
  if (moves) return std::nullopt;
  GroundTruthInstance instance;
  instance.category = CategoryOfKitti(tracklet.type);
  instance.model = NameOfType(tracklet.type);
  instance.fine = false;
  instance.size_m = tracklet.size_m;
  instance.world_from_object =
      Eigen::Translation3d(mean) *
      Eigen::AngleAxisd(std::atan2(front.y(), front.x()), Eigen::Vector3d::UnitZ());
  return instance;
}

/// Where it is, frame by frame; frames without a pose are passed over.
MovingThing MovingThingOf(const KittiTracklet& tracklet, std::size_t number,
                          const std::map<int, int>& frames,
                          const std::map<int, Eigen::Isometry3d>& world_from_velo) {
  MovingThing thing;
  thing.id = NameOfType(tracklet.type) + "_" + std::to_string(number);
  thing.category = CategoryOfKitti(tracklet.type);
  thing.size_m = tracklet.size_m;
  for (std::size_t i = 0; i < tracklet.places.size(); ++i) {
    const auto velo = world_from_velo.find(tracklet.first_frame + static_cast<int>(i));
    if (velo == world_from_velo.end()) continue;
    const KittiTracklet::Place& place = tracklet.places[i];
    thing.places.push_back(
        {frames.at(velo->first), velo->second * Eigen::Translation3d(place.position_in_velo) *
                                     Eigen::AngleAxisd(place.yaw_rad, Eigen::Vector3d::UnitZ())});
  }
  return thing;
}

}  // namespace

Likeness ProbeKittiRaw(const fs::path& path) {
  return IsThere(ImagesOfKittiRaw(path) / "timestamps.txt") ? Likeness::kCertain : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenKittiRaw(const fs::path& folder,
                                                     const SequenceOptions& options) {
  Result<KittiRig> rig = ReadKittiRig(folder);
  if (!rig.ok()) return rig.error();
  const fs::path images = ImagesOfKittiRaw(folder);
  const Result<std::vector<std::optional<std::int64_t>>> stamps =
      KittiStamps(images / "timestamps.txt");
  if (!stamps.ok()) return stamps.error();
  Recording recording;
  recording.path = folder;
  recording.calibration.cameras = {{rig->name, rig->camera.camera}};
  std::size_t without = 0;
  for (std::size_t i = 0; i < stamps->size(); ++i) {
    without += !(*stamps)[i].has_value();
    if ((*stamps)[i]) recording.frames.push_back({*(*stamps)[i], i, std::nullopt});
  }
  if (without > 0)
    recording.warnings.push_back("'" + (images / "timestamps.txt").string() + "' has " +
                                 std::to_string(without) + " lines that are no time; left out");
  if (recording.frames.empty())
    return Error{ErrorCode::kCorrupt, "'" + (images / "timestamps.txt").string() + "' has no time"};
  const PinholeCamera& pinhole = rig->camera.camera.pinhole;
  recording.read_image = [images, size = cv::Size(pinhole.width, pinhole.height),
                          extract = folder.string().find("_extract") !=
                                    std::string::npos](std::size_t number) -> Result<cv::Mat> {
    Result<cv::Mat> image = ReadImage(RawFile(images, number, ".png"), ImageKind::kColor, size);
    if (image.ok() || !extract || image.error().code != ErrorCode::kInvalidInput) return image;
    return Error{ErrorCode::kUnsupported,
                 image.error().message + ": the images of _extract are not rectified; read _sync"};
  };
  if (const fs::path oxts = folder / "oxts"; IsThere(oxts / "timestamps.txt")) {
    const Result<std::vector<StampedPacket>> packets = ReadOxts(oxts, recording.warnings);
    if (!packets.ok()) return packets.error();
    if (!packets->empty()) {
      recording.read_imu = [packets = *packets, oxts]() -> Result<ImuRecording> {
        ImuRecording imu;
        for (const StampedPacket& packet : packets) {
          imu.samples.push_back(packet.packet.imu);
          imu.samples.back().stamp_ns = packet.stamp_ns;
        }
        MakeStampsRise(oxts, "packets", imu.samples, imu.warnings);
        return imu;
      };
    }
    if (rig->cam_from_body && !packets->empty()) {
      JoinOxts(*packets, rig->cam_from_body->inverse(), recording.frames);
      recording.gravity_in_world = Eigen::Vector3d(0, 0, -1);
      recording.camera_height_m = kCameraHeight_m;
    }
  }
  return MakeSequence(std::move(recording), options);
}

Result<std::optional<GroundTruth>> TruthOfKittiRaw(const Sequence& sequence, const ModelFrames&,
                                                   std::vector<std::string>& warnings) {
  const fs::path file = sequence.path() / "tracklet_labels.xml";
  if (!IsThere(file)) return std::optional<GroundTruth>();
  const Result<std::vector<KittiTracklet>> tracklets = ReadKittiTracklets(file);
  if (!tracklets.ok()) return tracklets.error();
  const Result<KittiRig> rig = ReadKittiRig(sequence.path());
  if (!rig.ok()) return rig.error();
  if (!rig->cam_from_velo || !sequence.gravity_in_world())
    return Error{ErrorCode::kInvalidInput,
                 "'" + file.string() + "' needs calib_velo_to_cam.txt and poses (oxts/)"};
  const Result<std::vector<std::optional<std::int64_t>>> stamps =
      KittiStamps(ImagesOfKittiRaw(sequence.path()) / "timestamps.txt");
  if (!stamps.ok()) return stamps.error();
  // Tracklets count images by their number, of which the sequence may lack some.
  std::map<std::int64_t, int> numbers;
  for (std::size_t i = 0; i < stamps->size(); ++i) {
    if ((*stamps)[i]) numbers.emplace(*(*stamps)[i], static_cast<int>(i));
  }
  std::map<int, Eigen::Isometry3d> world_from_velo;
  std::map<int, int> frames;  // of the sequence
  for (int i = 0; i < sequence.num_frames(); ++i) {
    const auto number = numbers.find(sequence.stamp_ns(i));
    if (const auto pose = sequence.world_from_cam(i); pose && number != numbers.end()) {
      world_from_velo[number->second] = *pose * *rig->cam_from_velo;
      frames[number->second] = i;
    }
  }
  GroundTruth truth;
  truth.gravity_in_world = *sequence.gravity_in_world();
  int unplaced = 0;
  for (std::size_t i = 0; i < tracklets->size(); ++i) {
    bool moves = false;
    std::optional<GroundTruthInstance> instance =
        ParkedInstance((*tracklets)[i], world_from_velo, moves);
    if (moves) truth.moving.push_back(MovingThingOf((*tracklets)[i], i, frames, world_from_velo));
    unplaced += !instance && !moves;
    if (!instance) continue;
    instance->id = instance->model + "_" + std::to_string(i);
    truth.instances.push_back(std::move(*instance));
  }
  if (!truth.moving.empty())
    warnings.push_back("'" + file.string() + "' has " + std::to_string(truth.moving.size()) +
                       " objects that move; kept apart from the instances of the ground truth");
  if (unplaced > 0)
    warnings.push_back("'" + file.string() + "' has " + std::to_string(unplaced) +
                       " objects in frames without a pose; left out of the ground truth");
  return std::optional(std::move(truth));
}

}  // namespace plumbline
