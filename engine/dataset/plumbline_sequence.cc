// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/plumbline_sequence.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/dataset/frame_list.h"
#include "engine/dataset/json_fields.h"
#include "engine/dataset/proposals_file.h"
#include "engine/dataset/trajectory.h"
#include "engine/dataset/trajectory_writer.h"
#include "engine/dataset/undistort.h"
#include "engine/geometry/path_floor.h"
#include "engine/sensor/image_file.h"
#include "engine/sensor/undistorter.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr double kHighestLevel_m = 100;
constexpr double kLeastLevel_m2 = 1e-3;

bool Exists(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

struct Surroundings {
  std::optional<Eigen::Vector3d> gravity_in_world;
  std::optional<Eigen::Vector4d> floor_in_world;
  double floor_std_m = 0;
  std::optional<double> camera_height_m;  ///< Over a floor that is not told.
  std::vector<FloorLevel> floor_levels;
};

/// A level of gravity.json, or what is wrong with it.
Result<FloorLevel> LevelFromJson(const nlohmann::json& json) {
  const auto bad = [](const char* what) { return Error{ErrorCode::kInvalidInput, what}; };
  const auto finite = [](const nlohmann::json& number) {
    return number.is_number() && std::abs(number.get<double>()) < kHighestLevel_m;
  };
  if (!json.is_object() || !json.contains("height_m") || !finite(json["height_m"]))
    return bad("needs a number 'height_m' of less than 100 m, above the floor");
  FloorLevel level;
  level.height_m = json["height_m"];
  if (json.contains("std_m")) {
    if (!finite(json["std_m"]) || json["std_m"] < 0)
      return bad("has a 'std_m' that is not a number from 0 on");
    level.std_m = json["std_m"];
  }
  if (!json.contains("outline")) return level;
  const nlohmann::json& outline = json["outline"];
  const char* wrong = "has an 'outline' that is not a list of at least three points [x, y, z]";
  if (!outline.is_array() || outline.size() < 3) return bad(wrong);
  for (const nlohmann::json& corner : outline) {
    const std::optional<Eigen::VectorXd> point = VectorFromJson(corner, 3);
    if (!point || !(point->norm() < 1e6)) return bad(wrong);
    level.outline_in_world.emplace_back(*point);
  }
  return level;
}

/// Seen along gravity.
double AreaOf(const FloorLevel& level, const Eigen::Vector3d& gravity_in_world) {
  Eigen::Vector3d doubled = Eigen::Vector3d::Zero();
  const auto& corners = level.outline_in_world;
  for (std::size_t i = 0; i < corners.size(); ++i)
    doubled += corners[i].cross(corners[(i + 1) % corners.size()]);
  return 0.5 * std::abs(doubled.dot(gravity_in_world));
}

Result<Surroundings> ReadGravityFile(const fs::path& file, std::vector<std::string>& warnings) {
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' " + what};
  };
  const Result<nlohmann::json> read = ReadJson(file);
  if (!read.ok()) return read.error();
  const nlohmann::json& json = read.value();
  if (!json.is_object() || !json.contains("gravity")) return bad("has no 'gravity'");
  const std::optional<Eigen::VectorXd> gravity = VectorFromJson(json["gravity"], 3);
  if (!gravity || !(gravity->norm() > 1e-6 && gravity->norm() < 1e6))
    return bad("has a 'gravity' that is not a direction of three numbers");
  Surroundings result;
  result.gravity_in_world = gravity->normalized();
  if (!json.contains("floor") || json["floor"].is_null()) {
    if (json.contains("camera_height_m")) {
      const nlohmann::json& height = json["camera_height_m"];
      if (!height.is_number() || !(height > 0.05 && height < 100))
        return bad("has a 'camera_height_m' that is not a number between 0.05 and 100");
      result.camera_height_m = height;
    }
    if (json.contains("levels"))
      return bad("has 'levels' but no 'floor' that their heights are measured from");
    return result;
  }
  const std::optional<Eigen::VectorXd> floor = VectorFromJson(json["floor"], 4);
  if (!floor || !(floor->head<3>().norm() > 1e-6 && floor->norm() < 1e6))
    return bad("has a 'floor' that is not a plane [a, b, c, d]");
  Eigen::Vector4d plane = *floor / floor->head<3>().norm();
  double cosine = -plane.head<3>().dot(*result.gravity_in_world);
  if (cosine < 0) {
    warnings.push_back("'" + file.string() + "' has a floor whose normal points down; turned over");
    plane = -plane;
    cosine = -cosine;
  }
  if (cosine < std::cos(10.0 * M_PI / 180.0))
    return bad("has a 'floor' more than 10 degrees off the horizontal");
  result.floor_in_world = plane;
  if (!json.contains("levels")) return result;
  if (!json["levels"].is_array()) return bad("has 'levels' that are not a list");
  for (const nlohmann::json& entry : json["levels"]) {
    const std::string which = "has a level " + std::to_string(result.floor_levels.size());
    Result<FloorLevel> level = LevelFromJson(entry);
    if (!level.ok()) return bad(which + " that " + level.error().message);
    if (!level->outline_in_world.empty() &&
        AreaOf(*level, *result.gravity_in_world) < kLeastLevel_m2)
      return bad(which + " whose 'outline' has no area seen from above");
    result.floor_levels.push_back(std::move(level).value());
  }
  return result;
}

class PlumblineSequence : public Sequence {
 public:
  PlumblineSequence(fs::path folder, Calibration calibration, FrameList list)
      : folder_(std::move(folder)),
        calibration_(std::move(calibration)),
        undistorter_(camera_),
        list_(std::move(list)),
        poses_(list_.frames.size()),
        has_depth_(Exists(folder_ / "depth")),
        has_edges_(Exists(folder_ / "edges")),
        has_proposals_(Exists(folder_ / "proposals")) {}

  /// Reads gravity.json and the poses where there are any.
  /// @param poses  Instead of trajectory.txt; empty: that.
  Status ReadCompanions(const fs::path& poses);

  const fs::path& path() const override { return folder_; }
  int num_frames() const override { return static_cast<int>(list_.frames.size()); }
  const PinholeCamera& camera() const override { return camera_.pinhole; }
  const Calibration& calibration() const override { return calibration_; }
  double rate_hz() const override { return list_.rate_hz; }
  std::int64_t stamp_ns(int index) const override { return entry(index).stamp_ns; }
  std::optional<Eigen::Isometry3d> world_from_cam(int index) const override {
    entry(index);
    return poses_[index];
  }
  PoseUncertainty pose_uncertainty(int index) const override {
    entry(index);
    return uncertainties_.empty() ? PoseUncertainty{}
                                  : uncertainties_[static_cast<std::size_t>(index)];
  }
  std::optional<Eigen::Vector3d> gravity_in_world() const override {
    return surroundings_.gravity_in_world;
  }
  std::optional<Eigen::Vector4d> floor_in_world() const override {
    return surroundings_.floor_in_world;
  }
  double floor_std_m() const override { return surroundings_.floor_std_m; }
  std::vector<FloorLevel> floor_levels() const override { return surroundings_.floor_levels; }

  Result<Frame> ReadFrame(int index) const override;
  Result<cv::Mat> ReadRawImage(int index) const override;
  Result<std::optional<cv::Mat>> ReadDepth(int index) const override;
  Result<std::optional<EdgeMap>> ReadEdges(int index) const override;
  Result<std::optional<std::vector<Detection>>> ReadProposals(int index) const override;
  Result<ImuRecording> ReadImu() const override {
    return has_imu() ? ReadImuFile(folder_ / "imu.csv") : ImuRecording();
  }
  bool has_images() const override { return list_.has_images; }
  bool has_imu() const override { return Exists(folder_ / "imu.csv"); }
  bool has_depth() const override { return has_depth_; }
  bool has_edges() const override { return has_edges_; }
  bool has_proposals() const override { return has_proposals_; }

  std::optional<fs::path> scene_file() const override { return Companion("scene.ply"); }
  std::optional<fs::path> ground_truth_file() const override {
    return Companion("ground_truth.json");
  }
  std::optional<fs::path> models_folder() const override { return Companion("models"); }
  std::optional<fs::path> tracks_file() const override { return Companion("tracks.csv"); }
  std::optional<fs::path> reference_file() const override { return Companion("groundtruth.csv"); }
  const std::vector<std::string>& warnings() const override { return list_.warnings; }

 private:
  const FrameEntry& entry(int index) const {
    PLB_CHECK(index >= 0 && index < num_frames()) << "frame " << index << " of " << num_frames();
    return list_.frames[index];
  }
  cv::Size size() const { return {camera_.pinhole.width, camera_.pinhole.height}; }
  /// folder/STEM+ending for the frame's image STEM.jpg.
  fs::path Beside(int index, const char* folder, const char* ending) const {
    return folder_ / folder / (fs::path(entry(index).file).stem().string() + ending);
  }
  std::optional<fs::path> Companion(const char* name) const {
    return Exists(folder_ / name) ? std::optional(folder_ / name) : std::nullopt;
  }
  Status JoinUncertainties(const fs::path& file);
  /// From the path and the height of the camera over it.
  void FindFloor();
  /// @param file  Only for messages.
  void JoinPoses(const Trajectory& trajectory, const fs::path& file);
  /// For messages: the image's name or, without images, its time.
  std::string NameOf(int index) const {
    return list_.has_images ? entry(index).file
                            : std::to_string(static_cast<double>(stamp_ns(index)) * 1e-9) + " s";
  }

  fs::path folder_;
  Calibration calibration_;
  const Camera& camera_ = calibration_.cameras.front().camera;
  Undistorter undistorter_;
  FrameList list_;
  std::vector<std::optional<Eigen::Isometry3d>> poses_;
  std::vector<PoseUncertainty> uncertainties_;  ///< One for each frame, or empty.
  bool has_depth_;
  bool has_edges_;
  bool has_proposals_;
  Surroundings surroundings_;
};

Status PlumblineSequence::ReadCompanions(const fs::path& poses) {
  if (const fs::path file = folder_ / "gravity.json"; Exists(file)) {
    Result<Surroundings> read = ReadGravityFile(file, list_.warnings);
    if (!read.ok()) return read.error();
    surroundings_ = *read;
  }
  const fs::path file = poses.empty() ? folder_ / "trajectory.txt" : poses;
  if (!poses.empty() || Exists(file)) {
    const Result<Trajectory> trajectory = ReadTrajectory(file, camera_.body_from_cam);
    if (!trajectory.ok()) return trajectory.error();
    const std::vector<std::string>& odd = trajectory.value().warnings;
    list_.warnings.insert(list_.warnings.end(), odd.begin(), odd.end());
    JoinPoses(trajectory.value(), file);
    FindFloor();
    if (const fs::path beside = CovarianceFileOf(file); Exists(beside))
      return JoinUncertainties(beside);
  }
  return {};
}

void PlumblineSequence::FindFloor() {
  if (!surroundings_.camera_height_m) return;
  const auto floor =
      FloorUnderPath(poses_, -*surroundings_.gravity_in_world, *surroundings_.camera_height_m);
  if (!floor) {
    list_.warnings.push_back("'" + (folder_ / "gravity.json").string() +
                             "' tells the camera's height, but its path is too uneven for a plane "
                             "as floor; there is none");
    return;
  }
  surroundings_.floor_in_world = floor->floor_in_world;
  surroundings_.floor_std_m = floor->std_m;
}

Status PlumblineSequence::JoinUncertainties(const fs::path& file) {
  const Result<Covariances> covariances = ReadCovariances(file);
  if (!covariances.ok()) return covariances.error();
  list_.warnings.insert(list_.warnings.end(), covariances->warnings.begin(),
                        covariances->warnings.end());
  if (covariances->of_body && !camera_.body_from_cam) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + file.string() +
                     "' is of poses of the body (world_from_body) but camera.json has no "
                     "body_from_cam"};
  }
  uncertainties_.resize(poses_.size());
  const auto half_period_ns = static_cast<std::int64_t>(0.5e9 / list_.rate_hz);
  const std::vector<StampedCovariance>& rows = covariances->rows;
  int missing = 0;
  for (int i = 0; i < num_frames(); ++i) {
    if (!poses_[i]) continue;
    const auto row = std::lower_bound(
        rows.begin(), rows.end(), stamp_ns(i) - half_period_ns,
        [](const StampedCovariance& r, std::int64_t stamp) { return r.stamp_ns < stamp; });
    if (row == rows.end() || row->stamp_ns > stamp_ns(i) + half_period_ns) {
      ++missing;
      continue;
    }
    PoseUncertainty& uncertainty = uncertainties_[static_cast<std::size_t>(i)];
    PoseCovariance& covariance = covariances->independent ? uncertainty.own : uncertainty.drift;
    covariance = row->covariance;
    if (covariances->of_body) {
      const Eigen::Isometry3d& body_from_cam = *camera_.body_from_cam;
      covariance = MovedBy(
          poses_[i]->linear() * body_from_cam.linear().transpose() * body_from_cam.translation(),
          covariance);
    }
  }
  if (missing > 0) {
    list_.warnings.push_back("'" + file.string() + "' has no covariance for " +
                             std::to_string(missing) + " poses, which count as exact");
  }
  return {};
}

void PlumblineSequence::JoinPoses(const Trajectory& trajectory, const fs::path& file) {
  const auto half_period_ns = static_cast<std::int64_t>(0.5e9 / list_.rate_hz);
  int missing = 0;
  std::string first;
  for (int i = 0; i < num_frames(); ++i) {
    poses_[i] = trajectory.Nearest(stamp_ns(i), half_period_ns);
    if (poses_[i]) continue;
    if (missing++ == 0) first = NameOf(i);
  }
  if (missing > 0) {
    list_.warnings.push_back("'" + file.string() + "' has no pose within half a period of " +
                             std::to_string(missing) + " of " + std::to_string(num_frames()) +
                             " frames (such as '" + first + "')");
  }
}

Result<cv::Mat> PlumblineSequence::ReadRawImage(int index) const {
  if (!list_.has_images) {
    return Error{ErrorCode::kNotFound,
                 "'" + folder_.string() + "' has no images (there is no folder color/)"};
  }
  return ReadImage(folder_ / "color" / entry(index).file, ImageKind::kColor, size());
}

Result<Frame> PlumblineSequence::ReadFrame(int index) const {
  Result<cv::Mat> image = ReadRawImage(index);
  if (!image.ok()) return image.error();
  return Frame{index, stamp_ns(index), undistorter_.Undistort(*image), poses_[index]};
}

Result<std::optional<cv::Mat>> PlumblineSequence::ReadDepth(int index) const {
  if (!has_depth_ || !list_.has_images) return std::optional<cv::Mat>();
  const fs::path file = Beside(index, "depth", ".png");
  if (!Exists(file)) return std::optional<cv::Mat>();
  Result<cv::Mat> depth = ReadImage(file, ImageKind::kDepth, size());
  if (!depth.ok()) return Error{ErrorCode::kCorrupt, depth.error().message};
  return std::optional(undistorter_.UndistortNearest(*depth));
}

Result<std::optional<EdgeMap>> PlumblineSequence::ReadEdges(int index) const {
  if (!has_edges_ || !list_.has_images) return std::optional<EdgeMap>();
  const fs::path file = Beside(index, "edges", ".png");
  if (!Exists(file)) return std::optional<EdgeMap>();
  const Result<cv::Mat> probability = ReadImage(file, ImageKind::kGray, size());
  if (!probability.ok()) return Error{ErrorCode::kCorrupt, probability.error().message};
  const Result<cv::Mat> angle =
      ReadImage(Beside(index, "edges", "_angle.png"), ImageKind::kGray, size());
  if (!angle.ok())
    return Error{ErrorCode::kCorrupt, "edges without their angles: " + angle.error().message};
  return std::optional(UndistortEdges(camera_, {probability.value(), angle.value()}));
}

Result<std::optional<std::vector<Detection>>> PlumblineSequence::ReadProposals(int index) const {
  using Proposals = std::vector<Detection>;
  if (!has_proposals_ || !list_.has_images) return std::optional<Proposals>();
  const fs::path file = Beside(index, "proposals", ".json");
  if (!Exists(file)) return std::optional<Proposals>();
  Result<Proposals> proposals = ReadProposalsFile(file);
  if (!proposals.ok()) return Error{ErrorCode::kCorrupt, proposals.error().message};
  for (Detection& proposal : *proposals) proposal.box = UndistortBox(camera_, proposal.box);
  if (!camera_.distortion.empty())
    std::erase_if(*proposals, [](const Detection& proposal) { return proposal.box.empty(); });
  return std::optional(std::move(proposals).value());
}

}  // namespace

Likeness ProbePlumblineSequence(const fs::path& path) {
  if (Exists(path / "camera.json")) return Likeness::kCertain;
  return Exists(path / "color") || Exists(path / "tracks.csv") ? Likeness::kPossible
                                                               : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenPlumblineSequence(const fs::path& folder,
                                                              const SequenceOptions& options) {
  const fs::path camera_file = folder / "camera.json";
  const Result<nlohmann::json> json = ReadJson(camera_file);
  if (!json.ok()) return json.error();
  const Result<Camera> camera = CameraFromJson(json.value(), camera_file);
  if (!camera.ok()) return camera.error();
  Calibration calibration{{{"cam", camera.value()}}, std::nullopt};
  if (const fs::path file = folder / "imu.json"; Exists(file)) {
    const Result<nlohmann::json> imu_json = ReadJson(file);
    if (!imu_json.ok()) return imu_json.error();
    const Result<ImuCalibration> imu = ImuCalibrationFromJson(imu_json.value(), file);
    if (!imu.ok()) return imu.error();
    calibration.imu = imu.value();
  }
  const bool has_rate = json.value().contains("rate_hz");
  Result<FrameList> list =
      ListFrames(folder, has_rate ? std::optional(camera.value().rate_hz) : std::nullopt);
  if (!list.ok()) return list.error();
  auto sequence =
      std::make_shared<PlumblineSequence>(folder, std::move(calibration), std::move(list).value());
  const Status status = sequence->ReadCompanions(options.poses);
  if (!status.ok()) return status.error();
  return std::shared_ptr<const Sequence>(std::move(sequence));
}

}  // namespace plumbline
