// SPDX-License-Identifier: Apache-2.0
// Sequences and their files.
#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/asl_sensor_file.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/imu_file.h"
#include "engine/dataset/kitti_tracklets.h"
#include "engine/dataset/proposals_file.h"
#include "engine/dataset/reference_states.h"
#include "engine/dataset/ros_messages.h"
#include "engine/dataset/scannet_sequence.h"
#include "engine/dataset/scenenn_sequence.h"
#include "engine/dataset/sequence.h"
#include "engine/dataset/sequence_formats.h"
#include "engine/dataset/text_table.h"
#include "engine/dataset/tracks_file.h"
#include "engine/dataset/trajectory.h"
#include "engine/dataset/trajectory_writer.h"
#include "engine/dataset/visma_dataset.h"
#include "engine/dataset/visma_sequence.h"
#include "engine/sensor/image_file.h"
#include "engine/sources/imu_lines.h"
#include "engine/sources/recording_rig.h"
#include "tests/fuzz/fuzz_targets.h"

namespace plumbline::fuzz {
namespace {

Status TrajectoryFile(std::string_view input) {
  const auto file = FileOf("trajectory.txt", input);
  (void)ReadTrajectory(file, std::nullopt);  // refuses poses of the body
  return StatusOf(ReadTrajectory(file, Eigen::Isometry3d::Identity()));
}

Status CovarianceFile(std::string_view input) {
  return StatusOf(ReadCovariances(FileOf("trajectory.covariance.csv", input)));
}

Status ImuFile(std::string_view input) { return StatusOf(ReadImuFile(FileOf("imu.csv", input))); }

Status TracksFile(std::string_view input) {
  return StatusOf(ReadTracksFile(FileOf("tracks.csv", input)));
}

Status ReferenceFile(std::string_view input) {
  return StatusOf(ReadReferenceStates(FileOf("groundtruth.csv", input)));
}

Status GroundTruthFile(std::string_view input) {
  const auto file = FileOf("ground_truth.json", input);
  const auto truth = ReadGroundTruth(file);
  if (!truth.ok()) return truth.error();
  if (const Status written = WriteGroundTruth(file, *truth); !written.ok()) return written;
  return StatusOf(ReadGroundTruth(file));  // what is written is read again
}

Status ProposalsFile(std::string_view input) {
  const auto file = FileOf("proposals.json", input);
  const auto proposals = ReadProposalsFile(file);
  if (!proposals.ok()) return proposals.error();
  if (const Status written = WriteJson(file, ProposalsToJson("a.png", *proposals)); !written.ok())
    return written;
  return StatusOf(ReadProposalsFile(file));
}

Status AslSensor(std::string_view input) {
  const auto file = FileOf("sensor.yaml", input);
  (void)ReadAslImu(file);
  return StatusOf(ReadAslCamera(file));
}

Status ImuLines(std::string_view input) {
  Status status;
  for (const std::string_view line : SplitLines(input)) {
    if (!ParseImuLine(line)) status = InvalidInput("a line that is no reading");
  }
  return status;
}
Status AslImu(std::string_view input) { return StatusOf(ReadAslImu(FileOf("imu.yaml", input))); }

/// All that is asked of a sequence; images that cannot be read are passed over by those who ask.
Status WholeSequence(const std::filesystem::path& folder) {
  const auto opened = OpenSequence(folder);
  if (!opened.ok()) return opened.error();
  const Sequence& sequence = **opened;
  (void)NumPosedFrames(sequence);
  std::vector<std::string> warnings;
  (void)ReadTruthOf(sequence, warnings);
  const auto imu = sequence.ReadImu();
  Status status = StatusOf(imu);
  for (int i = 0; i < std::min(sequence.num_frames(), 3); ++i) {
    (void)sequence.ReadFrame(i);
    (void)sequence.ReadDepth(i);
    (void)sequence.ReadEdges(i);
    if (const auto proposals = sequence.ReadProposals(i); !proposals.ok() && status.ok())
      status = proposals.error();
  }
  return status;
}

Status SequenceFolder(std::string_view input) { return WholeSequence(FolderOf(input)); }

Status RosBagFile(std::string_view input) { return WholeSequence(FileOf("sample.bag", input)); }

Status KittiTracklets(std::string_view input) {
  return StatusOf(ReadKittiTracklets(FileOf("tracklet_labels.xml", input)));
}

Status ScanNetSens(std::string_view input) {
  return WholeSequence(FileOf("scene0042_01.sens", input));
}

Status Scan2Cad(std::string_view input) {
  std::vector<std::string> warnings;
  return StatusOf(
      ReadScan2Cad(FileOf("full_annotations.json", input), {}, "scene0042_01", warnings));
}

Status VismaDatasetFile(std::string_view input) {
  return StatusOf(ReadVismaDataset(FileOf("dataset", input)));
}

Status VismaBoxes(std::string_view input) {
  return StatusOf(ReadVismaBoxes(FileOf("1.bbox", input)));
}

Status VismaTruth(std::string_view input) {
  std::vector<std::string> warnings;
  return StatusOf(ReadVismaTruth(FolderOf(input), {}, warnings));
}

Status SceneNnLabels(std::string_view input) {
  return StatusOf(ReadSceneNnLabels(FileOf("123.xml", input)));
}

/// As every message that is read; those of other kinds are refused.
Status RosMessage(std::string_view input) {
  (void)ParseRosHeader(input);
  (void)ParseRosEncoding(input);
  (void)ParseRosDepth(input);
  (void)ParseRosCompressed(input);
  (void)ParseRosCameraInfo(input);
  (void)ParseRosImu(input);
  (void)ParseRosTransforms(input);
  return StatusOf(ParseRosImage(input));
}

Status Image(std::string_view input) {
  const auto file = FileOf("image.png", input);
  (void)ReadImage(file, ImageKind::kDepth);
  (void)ReadImage(file, ImageKind::kGray, cv::Size(4, 4));
  return StatusOf(ReadImage(file, ImageKind::kColor));
}

Status Rig(std::string_view input) { return StatusOf(ReadRecordingRig(FolderOf(input))); }

constexpr std::array kDatasetTargets = {Target{"trajectory", TrajectoryFile},
                                        Target{"covariances", CovarianceFile},
                                        Target{"imu", ImuFile},
                                        Target{"imu_lines", ImuLines},
                                        Target{"recording_rig", Rig},
                                        Target{"tracks", TracksFile},
                                        Target{"reference_states", ReferenceFile},
                                        Target{"ground_truth", GroundTruthFile},
                                        Target{"proposals", ProposalsFile},
                                        Target{"asl_camera", AslSensor},
                                        Target{"asl_imu", AslImu},
                                        Target{"asl_sequence", SequenceFolder},
                                        Target{"sequence", SequenceFolder},
                                        Target{"seven_scenes", SequenceFolder},
                                        Target{"tum_rgbd", SequenceFolder},
                                        Target{"icl_nuim", SequenceFolder},
                                        Target{"kitti_raw", SequenceFolder},
                                        Target{"kitti_odometry", SequenceFolder},
                                        Target{"kitti_tracklets", KittiTracklets},
                                        Target{"scannet_sens", ScanNetSens},
                                        Target{"scannet_extracted", SequenceFolder},
                                        Target{"scan2cad", Scan2Cad},
                                        Target{"visma_dataset", VismaDatasetFile},
                                        Target{"visma_boxes", VismaBoxes},
                                        Target{"visma_truth", VismaTruth},
                                        Target{"scenenn", SequenceFolder},
                                        Target{"scenenn_labels", SceneNnLabels},
                                        Target{"bop_scene", SequenceFolder},
                                        Target{"ros_bag", RosBagFile},
                                        Target{"ros_message", RosMessage},
                                        Target{"image", Image}};

}  // namespace

std::span<const Target> DatasetTargets() { return kDatasetTargets; }

}  // namespace plumbline::fuzz
