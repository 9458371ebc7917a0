// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/sequence_writing.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/proposals_file.h"
#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/trajectory_writer.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

Status WriteEncoded(const fs::path& file, const cv::Mat& image, const std::vector<int>& how) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(file.extension().string(), image, bytes, how))
    return Error{ErrorCode::kIo, "cannot encode the image '" + file.string() + "'"};
  // Thousands of these: what a power cut leaves is a folder to be made again.
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) return Error{ErrorCode::kIo, "cannot write '" + file.string() + "'; is the disk full?"};
  return {};
}

/// Millimetres in other units; what does not fit is none.
cv::Mat DepthInUnits(const cv::Mat& depth_mm, double units_per_metre) {
  if (units_per_metre == 1000) return depth_mm;
  cv::Mat depth(depth_mm.size(), CV_16UC1);
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      const double units = std::round(depth_mm.at<std::uint16_t>(y, x) * (units_per_metre / 1000));
      depth.at<std::uint16_t>(y, x) = units < 65536 ? static_cast<std::uint16_t>(units) : 0;
    }
  }
  return depth;
}

Status WriteImuFiles(const Sequence& sequence, const fs::path& folder,
                     std::vector<std::string>& warnings) {
  const Result<ImuRecording> imu = sequence.ReadImu();
  if (!imu.ok()) {
    warnings.push_back(imu.error().message + "; no imu.csv is written");
    return {};
  }
  std::string rows = "t,wx,wy,wz,ax,ay,az\n";
  for (const ImuSample& sample : imu->samples) {
    const Eigen::Vector3d &w = sample.angular_velocity_rad_s, &a = sample.specific_force_m_s2;
    char row[300];
    std::snprintf(row, sizeof row, "%s,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n",
                  StampText(sample.stamp_ns).c_str(), w.x(), w.y(), w.z(), a.x(), a.y(), a.z());
    rows += row;
  }
  if (Status status = WriteFileAtomically(folder / "imu.csv", rows); !status.ok()) return status;
  const auto& noise = sequence.calibration().imu;
  if (!noise) return {};
  nlohmann::json json = {{"rate_hz", noise->rate_hz},
                         {"gyro_noise_density", noise->gyro_noise_density},
                         {"accel_noise_density", noise->accel_noise_density},
                         {"gyro_bias_walk", noise->gyro_bias_walk},
                         {"accel_bias_walk", noise->accel_bias_walk},
                         {"time_offset_s", noise->time_offset_s},
                         {"gravity_m_s2", noise->gravity_m_s2}};
  if (noise->saturation_gyro_rad_s) json["saturation_gyro_rad_s"] = *noise->saturation_gyro_rad_s;
  if (noise->saturation_accel_m_s2) json["saturation_accel_m_s2"] = *noise->saturation_accel_m_s2;
  return WriteJson(folder / "imu.json", json);
}

Status WriteGravity(const Sequence& sequence, const fs::path& folder) {
  const auto gravity = sequence.gravity_in_world();
  if (!gravity) return {};
  nlohmann::json json = {{"gravity", {gravity->x(), gravity->y(), gravity->z()}}};
  if (const auto floor = sequence.floor_in_world())
    json["floor"] = std::vector<double>(floor->data(), floor->data() + 4);
  return WriteJson(folder / "gravity.json", json);
}

Status WriteProposals(const Sequence& sequence, const fs::path& folder,
                      const std::vector<std::pair<int, std::string>>& images,
                      std::vector<std::string>& warnings) {
  std::error_code error;
  fs::create_directories(folder / "proposals", error);
  int damaged = 0;
  for (const auto& [index, image] : images) {
    const auto proposals = sequence.ReadProposals(index);
    damaged += !proposals.ok();
    if (!proposals.ok() || !proposals->has_value()) continue;
    const fs::path file = folder / "proposals" / (fs::path(image).stem().string() + ".json");
    if (Status written = WriteJson(file, ProposalsToJson(image, **proposals)); !written.ok())
      return written;
  }
  if (damaged > 0)
    warnings.push_back(std::to_string(damaged) + " files of proposals are damaged; left out");
  return {};
}

/// The scan, the models and the truth, as far as they can be had.
Status WriteSurroundings(const Sequence& sequence, const fs::path& folder,
                         const ModelFrames& frames, std::vector<std::string>& warnings) {
  std::error_code error;
  if (const auto scan = sequence.scene_file(); scan && scan->extension() == ".ply") {
    fs::copy_file(*scan, folder / "scene.ply", error);
    if (error)
      return Error{ErrorCode::kIo,
                   "cannot copy the scan '" + scan->string() + "': " + error.message()};
  }
  if (const auto models = sequence.models_folder(); models && IsThere(*models / "models.json")) {
    fs::copy(*models, folder / "models", fs::copy_options::recursive, error);
    if (error)
      return Error{ErrorCode::kIo,
                   "cannot copy the models '" + models->string() + "': " + error.message()};
  }
  const Result<std::optional<GroundTruth>> truth = ReadTruthOf(sequence, warnings, frames);
  if (!truth.ok()) {
    warnings.push_back(truth.error().message + "; no ground_truth.json is written");
    return {};
  }
  if (!truth->has_value()) return {};
  return WriteGroundTruth(folder / "ground_truth.json", **truth);
}

}  // namespace

std::string StampText(std::int64_t stamp_ns) {
  char text[40];
  const bool negative = stamp_ns < 0;
  const std::uint64_t size =
      negative ? 0 - static_cast<std::uint64_t>(stamp_ns) : static_cast<std::uint64_t>(stamp_ns);
  std::snprintf(text, sizeof text, "%s%" PRIu64 ".%09" PRIu64, negative ? "-" : "",
                size / 1'000'000'000, size % 1'000'000'000);
  return text;
}

Status MakeFolderFor(const fs::path& folder, const std::vector<std::string>& inside) {
  std::error_code error;
  if (fs::exists(folder, error) &&
      !(fs::is_directory(folder, error) && fs::is_empty(folder, error)))
    return Error{ErrorCode::kInvalidInput,
                 "'" + folder.string() + "' is there already; name a folder that is new or empty"};
  fs::create_directories(folder, error);
  for (const std::string& name : inside) {
    if (!error) fs::create_directories(folder / name, error);
  }
  if (error)
    return Error{ErrorCode::kIo,
                 "cannot make the folder '" + folder.string() + "': " + error.message()};
  return {};
}

bool IsUndistortedOnWriting(const Sequence& sequence, const ImagePlaces& places) {
  return places.undistort || (sequence.has_depth() && !places.depth_folder.empty());
}

Result<WrittenSequence> WriteImages(
    const Sequence& sequence, const ImagePlaces& places, const WriteOptions& options,
    const WorkContext& context,
    const std::function<void(int, const std::string&, const std::string&)>& written) {
  if (!sequence.has_images())
    return Error{ErrorCode::kInvalidInput,
                 "'" + sequence.path().string() + "' has no images; there is nothing to convert"};
  const bool undistort = IsUndistortedOnWriting(sequence, places);
  const std::string ending = options.jpeg_quality ? ".jpg" : ".png";
  const std::vector<int> how =
      options.jpeg_quality ? std::vector<int>{cv::IMWRITE_JPEG_QUALITY, *options.jpeg_quality}
                           : std::vector<int>{};
  WrittenSequence result;
  for (int i = 0; i < sequence.num_frames(); ++i) {
    if (context.stop.stop_requested())
      return Error{ErrorCode::kCancelled, "stopped after " + std::to_string(i) + " frames"};
    context.report({"frames", i, sequence.num_frames()});
    char number[20];
    std::snprintf(number, sizeof number, "%06d", i);
    const std::string stem = places.by_stamp ? StampText(sequence.stamp_ns(i)) : number;
    Result<cv::Mat> raw = undistort ? Result<cv::Mat>(cv::Mat()) : sequence.ReadRawImage(i);
    if (undistort) {
      Result<Frame> frame = sequence.ReadFrame(i);
      raw = frame.ok() ? Result<cv::Mat>(frame->image) : Result<cv::Mat>(frame.error());
    }
    if (!raw.ok()) {
      ++result.skipped;
      if (result.skipped == 1) result.warnings.push_back(raw.error().message + "; frame skipped");
      continue;
    }
    if (Status status = WriteEncoded(places.image_folder / (stem + ending), *raw, how);
        !status.ok())
      return status.error();
    ++result.frames;
    std::string depth_name;
    if (!places.depth_folder.empty() && sequence.has_depth()) {
      const Result<std::optional<cv::Mat>> depth = sequence.ReadDepth(i);
      if (!depth.ok()) {
        result.warnings.push_back(depth.error().message + "; depth left out");
      } else if (depth->has_value()) {
        depth_name = stem + ".png";
        if (Status status = WriteEncoded(places.depth_folder / depth_name,
                                         DepthInUnits(**depth, places.depth_units_per_metre), {});
            !status.ok())
          return status.error();
        ++result.depth_images;
      }
    }
    written(i, stem + ending, depth_name);
  }
  if (result.frames == 0)
    return Error{ErrorCode::kCorrupt,
                 "no image of '" + sequence.path().string() + "' can be read (" +
                     (result.warnings.empty() ? "" : result.warnings.front()) + ")"};
  return result;
}

Result<WrittenSequence> WritePlumblineSequence(const Sequence& sequence, const fs::path& folder,
                                               const WriteOptions& options,
                                               const WorkContext& context) {
  std::vector<std::string> inside = {"color"};
  if (sequence.has_depth()) inside.emplace_back("depth");
  if (Status made = MakeFolderFor(folder, inside); !made.ok()) return made.error();
  const ImagePlaces places{folder / "color", sequence.has_depth() ? folder / "depth" : fs::path(),
                           1000};
  std::string table = "stamp_s,file\n";
  std::vector<WrittenPose> poses;
  std::vector<std::pair<int, std::string>> images;
  Result<WrittenSequence> written =
      WriteImages(sequence, places, options, context,
                  [&](int index, const std::string& image, const std::string&) {
                    table += StampText(sequence.stamp_ns(index)) + "," + image + "\n";
                    images.emplace_back(index, image);
                    if (const auto pose = sequence.world_from_cam(index))
                      poses.push_back({sequence.stamp_ns(index), *pose, PoseCovariance::Zero()});
                  });
  if (!written.ok()) return written;
  Camera camera = sequence.calibration().cameras.front().camera;
  camera.rate_hz = sequence.rate_hz();
  if (IsUndistortedOnWriting(sequence, places)) {
    camera.model = CameraModel::kPinhole;
    camera.distortion.clear();
    camera.pinhole = sequence.camera();
  }
  Status status = WriteJson(folder / "camera.json", CameraToJson(camera));
  if (status.ok()) status = WriteFileAtomically(folder / "color.csv", table);
  if (status.ok() && !poses.empty())
    status = WriteTrajectory(folder / "trajectory.txt", "world_from_cam", poses);
  if (status.ok()) status = WriteGravity(sequence, folder);
  if (status.ok() && sequence.has_imu())
    status = WriteImuFiles(sequence, folder, written->warnings);
  // Proposals are asked for undistorted, and are written for the image as it was written.
  if (status.ok() && sequence.has_proposals() && camera.distortion.empty())
    status = WriteProposals(sequence, folder, images, written->warnings);
  if (status.ok()) status = WriteSurroundings(sequence, folder, options.models, written->warnings);
  if (!status.ok()) return status.error();
  written->poses = static_cast<int>(poses.size());
  return written;
}

}  // namespace plumbline
