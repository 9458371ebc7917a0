// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/asl_sequence.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/data_paths.h"
#include "engine/base/files.h"
#include "engine/dataset/asl_sensor_file.h"
#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/sequence_writing.h"
#include "engine/dataset/stamp_statistics.h"
#include "engine/dataset/stamped_rows.h"
#include "engine/dataset/text_table.h"
#include "engine/dataset/trajectory.h"
#include "engine/geometry/reach.h"
#include "engine/sensor/image_file.h"
#include "engine/sensor/undistorter.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

/// The folder with cam0 and imu0 in it.
fs::path SensorRoot(const fs::path& folder) {
  return IsThere(folder / "mav0") ? folder / "mav0" : folder;
}

struct AslImage {
  std::int64_t stamp_ns = 0;
  std::string file;
};

/// Rows `stamp [ns],file`.
Result<std::vector<AslImage>> ReadImageList(const fs::path& file,
                                            std::vector<std::string>& warnings) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  std::vector<AslImage> images;
  LineWarnings odd(file.string());
  std::size_t number = 0;
  for (const std::string_view line : SplitLines(*text)) {
    ++number;
    const std::vector<std::string_view> fields = SplitFields(line);
    if (fields.empty() || fields[0].starts_with('#')) continue;
    const auto stamp = ParseStampNs(fields[0]);
    if (fields.size() != 2 || !stamp) {
      odd.Add("not a stamp and the name of an image; row left out", number);
      continue;
    }
    if (!PlaceInside(file.parent_path() / "data", std::string(fields[1])).ok()) {
      odd.Add("the image lies outside of the folder data/ (--allow-outside reads it); row left out",
              number);
      continue;
    }
    images.push_back({*stamp, std::string(fields[1])});
  }
  warnings = odd.Sentences();
  MakeStampsRise(file, "images", images, warnings);
  if (images.empty()) return Error{ErrorCode::kCorrupt, "'" + file.string() + "' lists no image"};
  return images;
}

/// world_from_body from rows `t,px,py,pz,qw,qx,qy,qz[,..]`, as world_from_cam.
Result<Trajectory> ReadAslPoses(const fs::path& file, bool velocities,
                                const Eigen::Isometry3d& body_from_cam) {
  Trajectory trajectory;
  int unusable = 0;
  const auto rows = ReadStampedRows(
      file, {velocities ? "t,p,q wxyz,v,b_gyro,b_accel" : "t,p,q wxyz", velocities ? 16 : 7},
      [&](std::int64_t stamp_ns, std::span<const double> n) {
        const Eigen::Quaterniond q(n[3], n[4], n[5], n[6]);
        const Eigen::Vector3d position(n[0], n[1], n[2]);
        if (!(std::abs(q.norm() - 1) < 0.01) || position.cwiseAbs().maxCoeff() > kFarthest_m)
          return void(++unusable);
        Eigen::Isometry3d pose(q.normalized());
        pose.translation() = position;
        trajectory.poses.push_back({stamp_ns, pose * body_from_cam});
      });
  if (!rows.ok()) return rows.error();
  trajectory.warnings = *rows;
  if (unusable > 0) {
    trajectory.warnings.push_back("'" + file.string() + "' has " + std::to_string(unusable) +
                                  " rows whose quaternion is not of length 1 or that are more "
                                  "than 1000 km from the origin; left out");
  }
  MakeStampsRise(file, "poses", trajectory.poses, trajectory.warnings);
  return trajectory;
}

class AslSequence : public Sequence {
 public:
  AslSequence(fs::path folder, Calibration calibration, std::vector<AslImage> images,
              std::vector<std::string> warnings)
      : folder_(std::move(folder)),
        root_(SensorRoot(folder_)),
        calibration_(std::move(calibration)),
        undistorter_(camera_),
        images_(std::move(images)),
        poses_(images_.size()),
        warnings_(std::move(warnings)) {
    std::vector<std::int64_t> stamps;
    for (const AslImage& image : images_) stamps.push_back(image.stamp_ns);
    const double measured = StatisticsOf(stamps, 1.5).rate_hz();
    rate_hz_ = measured > 0 ? measured : camera_.rate_hz;
  }

  Status ReadPoses(const fs::path& given);

  const fs::path& path() const override { return folder_; }
  int num_frames() const override { return static_cast<int>(images_.size()); }
  const PinholeCamera& camera() const override { return camera_.pinhole; }
  const Calibration& calibration() const override { return calibration_; }
  double rate_hz() const override { return rate_hz_; }
  std::int64_t stamp_ns(int index) const override { return image(index).stamp_ns; }
  std::optional<Eigen::Isometry3d> world_from_cam(int index) const override {
    image(index);
    return poses_[static_cast<std::size_t>(index)];
  }
  std::optional<Eigen::Vector3d> gravity_in_world() const override {
    return Eigen::Vector3d(0, 0, -1);
  }
  std::optional<Eigen::Vector4d> floor_in_world() const override { return std::nullopt; }

  Result<cv::Mat> ReadRawImage(int index) const override {
    return ReadImage(root_ / "cam0" / "data" / image(index).file, ImageKind::kColor,
                     cv::Size(camera_.pinhole.width, camera_.pinhole.height));
  }
  Result<Frame> ReadFrame(int index) const override {
    Result<cv::Mat> raw = ReadRawImage(index);
    if (!raw.ok()) return raw.error();
    return Frame{index, stamp_ns(index), undistorter_.Undistort(*raw), world_from_cam(index)};
  }
  Result<std::optional<cv::Mat>> ReadDepth(int) const override { return std::optional<cv::Mat>(); }
  Result<std::optional<EdgeMap>> ReadEdges(int) const override { return std::optional<EdgeMap>(); }
  Result<std::optional<std::vector<Detection>>> ReadProposals(int) const override {
    return std::optional<std::vector<Detection>>();
  }
  Result<ImuRecording> ReadImu() const override {
    return has_imu() ? ReadImuFile(root_ / "imu0" / "data.csv") : ImuRecording();
  }
  bool has_images() const override { return true; }
  bool has_imu() const override { return IsThere(root_ / "imu0" / "data.csv"); }
  bool has_depth() const override { return false; }
  bool has_edges() const override { return false; }
  bool has_proposals() const override { return false; }
  std::optional<fs::path> scene_file() const override { return std::nullopt; }
  std::optional<fs::path> ground_truth_file() const override { return std::nullopt; }
  std::optional<fs::path> models_folder() const override { return std::nullopt; }
  std::optional<fs::path> tracks_file() const override { return std::nullopt; }
  std::optional<fs::path> reference_file() const override { return std::nullopt; }
  const std::vector<std::string>& warnings() const override { return warnings_; }

 private:
  const AslImage& image(int index) const {
    PLB_CHECK(index >= 0 && index < num_frames()) << "frame " << index << " of " << num_frames();
    return images_[static_cast<std::size_t>(index)];
  }

  fs::path folder_, root_;
  Calibration calibration_;
  const Camera& camera_ = calibration_.cameras.front().camera;
  Undistorter undistorter_;
  std::vector<AslImage> images_;
  std::vector<std::optional<Eigen::Isometry3d>> poses_;
  std::vector<std::string> warnings_;
  double rate_hz_ = 0;
};

Status AslSequence::ReadPoses(const fs::path& given) {
  const fs::path states = root_ / "state_groundtruth_estimate0" / "data.csv",
                 mocap = root_ / "mocap0" / "data.csv";
  if (given.empty() && !IsThere(states) && !IsThere(mocap)) return {};
  const Result<Trajectory> poses =
      !given.empty()
          ? ReadTrajectory(given, camera_.body_from_cam)
          : ReadAslPoses(IsThere(states) ? states : mocap, IsThere(states), *camera_.body_from_cam);
  if (!poses.ok()) return poses.error();
  warnings_.insert(warnings_.end(), poses->warnings.begin(), poses->warnings.end());
  const auto half_period_ns = static_cast<std::int64_t>(0.5e9 / rate_hz_);
  for (std::size_t i = 0; i < images_.size(); ++i)
    poses_[i] = poses->Nearest(images_[i].stamp_ns, half_period_ns);
  return {};
}

std::string AslNumbers(std::span<const double> numbers) {
  std::string text;
  for (const double number : numbers) {
    char one[40];
    std::snprintf(one, sizeof one, "%s%.12g", text.empty() ? "" : ", ", number);
    text += one;
  }
  return "[" + text + "]";
}

std::string AslCameraText(const Camera& camera, const Eigen::Isometry3d& body_from_cam) {
  const PinholeCamera& c = camera.pinhole;
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> pose = body_from_cam.matrix();
  const std::vector<double> distortion =
      camera.distortion.empty() ? std::vector<double>(4, 0) : camera.distortion;
  return "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: " +
         AslNumbers({pose.data(), 16}) + "\nrate_hz: " + std::to_string(camera.rate_hz) +
         "\nresolution: " + AslNumbers(std::vector<double>{1.0 * c.width, 1.0 * c.height}) +
         "\ncamera_model: pinhole\nintrinsics: " +
         AslNumbers(std::vector<double>{c.fx, c.fy, c.cx, c.cy}) + "\ndistortion_model: " +
         (camera.model == CameraModel::kEquidistant ? "equidistant" : "radial-tangential") +
         "\ndistortion_coefficients: " + AslNumbers(distortion) + "\n";
}

Status WriteAslImu(const Sequence& sequence, const fs::path& folder,
                   std::vector<std::string>& warnings) {
  const Result<ImuRecording> imu = sequence.ReadImu();
  if (!imu.ok()) {
    warnings.push_back(imu.error().message + "; no imu0 is written");
    return {};
  }
  std::string rows = "#timestamp [ns],wx,wy,wz [rad/s],ax,ay,az [m/s^2]\n";
  for (const ImuSample& sample : imu->samples) {
    const Eigen::Vector3d &w = sample.angular_velocity_rad_s, &a = sample.specific_force_m_s2;
    char row[240];
    std::snprintf(row, sizeof row, "%s,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n",
                  std::to_string(sample.stamp_ns).c_str(), w.x(), w.y(), w.z(), a.x(), a.y(),
                  a.z());
    rows += row;
  }
  const ImuCalibration noise = sequence.calibration().imu.value_or(ImuCalibration());
  char text[400];
  std::snprintf(text, sizeof text,
                "sensor_type: imu\nrate_hz: %.9g\ngyroscope_noise_density: %.9g\n"
                "gyroscope_random_walk: %.9g\naccelerometer_noise_density: %.9g\n"
                "accelerometer_random_walk: %.9g\n",
                noise.rate_hz, noise.gyro_noise_density, noise.gyro_bias_walk,
                noise.accel_noise_density, noise.accel_bias_walk);
  Status status = WriteFileAtomically(folder / "data.csv", rows);
  if (status.ok() && sequence.calibration().imu)
    status = WriteFileAtomically(folder / "sensor.yaml", text);
  return status;
}

}  // namespace

Result<WrittenSequence> WriteAslSequence(const Sequence& sequence, const fs::path& folder,
                                         const WriteOptions& options, const WorkContext& context) {
  const fs::path root = folder / "mav0";
  std::vector<std::string> inside = {"mav0/cam0/data"};
  if (sequence.has_imu()) inside.emplace_back("mav0/imu0");
  if (NumPosedFrames(sequence) > 0) inside.emplace_back("mav0/mocap0");
  if (Status made = MakeFolderFor(folder, inside); !made.ok()) return made.error();
  Camera camera = sequence.calibration().cameras.front().camera;
  camera.rate_hz = sequence.rate_hz();
  ImagePlaces places{root / "cam0" / "data", {}, 1000};
  places.undistort = camera.model == CameraModel::kFov;
  if (places.undistort) camera.distortion.clear();
  const Eigen::Isometry3d body_from_cam =
      camera.body_from_cam.value_or(Eigen::Isometry3d::Identity());
  Eigen::Isometry3d level_from_world = Eigen::Isometry3d::Identity();
  if (const auto gravity = sequence.gravity_in_world())
    level_from_world.linear() =
        Eigen::Quaterniond::FromTwoVectors(*gravity, Eigen::Vector3d(0, 0, -1)).toRotationMatrix();
  std::string images = "#timestamp [ns],filename\n",
              poses = "#timestamp [ns],px,py,pz [m],qw,qx,qy,qz\n";
  int posed = 0;
  auto written = WriteImages(
      sequence, places, options, context,
      [&](int index, const std::string& image, const std::string&) {
        images += std::to_string(sequence.stamp_ns(index)) + "," + image + "\n";
        const auto pose = sequence.world_from_cam(index);
        if (!pose) return;
        ++posed;
        const Eigen::Isometry3d body = level_from_world * *pose * body_from_cam.inverse();
        const Eigen::Quaterniond q(body.linear());
        const Eigen::Vector3d& p = body.translation();
        char row[260];
        std::snprintf(row, sizeof row, "%s,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n",
                      std::to_string(sequence.stamp_ns(index)).c_str(), p.x(), p.y(), p.z(), q.w(),
                      q.x(), q.y(), q.z());
        poses += row;
      });
  if (!written.ok()) return written;
  if (posed > 0 && !sequence.gravity_in_world())
    written->warnings.push_back("gravity is not known: the poses that were written are not z up");
  Status status = WriteFileAtomically(root / "cam0" / "data.csv", images);
  if (status.ok())
    status =
        WriteFileAtomically(root / "cam0" / "sensor.yaml", AslCameraText(camera, body_from_cam));
  if (status.ok() && posed > 0) status = WriteFileAtomically(root / "mocap0" / "data.csv", poses);
  if (status.ok() && sequence.has_imu())
    status = WriteAslImu(sequence, root / "imu0", written->warnings);
  if (!status.ok()) return status.error();
  written->poses = posed;
  return written;
}

Likeness ProbeAslSequence(const fs::path& path) {
  return IsThere(SensorRoot(path) / "cam0" / "data.csv") ? Likeness::kCertain : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenAslSequence(const fs::path& folder,
                                                        const SequenceOptions& options) {
  const fs::path root = SensorRoot(folder);
  const Result<Camera> camera = ReadAslCamera(root / "cam0" / "sensor.yaml");
  if (!camera.ok()) return camera.error();
  Calibration calibration{{{"cam0", *camera}}, std::nullopt};
  if (const fs::path file = root / "imu0" / "sensor.yaml"; IsThere(file)) {
    const Result<ImuCalibration> imu = ReadAslImu(file);
    if (!imu.ok()) return imu.error();
    calibration.imu = *imu;
  }
  std::vector<std::string> warnings;
  Result<std::vector<AslImage>> images = ReadImageList(root / "cam0" / "data.csv", warnings);
  if (!images.ok()) return images.error();
  auto sequence = std::make_shared<AslSequence>(folder, std::move(calibration), std::move(*images),
                                                std::move(warnings));
  const Status status = sequence->ReadPoses(options.poses);
  if (!status.ok()) return status.error();
  return std::shared_ptr<const Sequence>(std::move(sequence));
}

}  // namespace plumbline
