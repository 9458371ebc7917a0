// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/sequence_formats.h"

#include <utility>

#include "engine/dataset/asl_sequence.h"
#include "engine/dataset/bop_sequence.h"
#include "engine/dataset/icl_nuim_sequence.h"
#include "engine/dataset/kitti_odometry_sequence.h"
#include "engine/dataset/kitti_raw_sequence.h"
#include "engine/dataset/plumbline_sequence.h"
#include "engine/dataset/ros_bag_sequence.h"
#include "engine/dataset/scannet_sequence.h"
#include "engine/dataset/scenenn_sequence.h"
#include "engine/dataset/sequence_writing.h"
#include "engine/dataset/seven_scenes_sequence.h"
#include "engine/dataset/tum_rgbd_sequence.h"
#include "engine/dataset/visma_sequence.h"

namespace plumbline {
namespace {

Result<std::optional<GroundTruth>> TruthOfPlumbline(const Sequence& sequence, const ModelFrames&,
                                                    std::vector<std::string>&) {
  const auto file = sequence.ground_truth_file();
  if (!file) return std::optional<GroundTruth>();
  Result<GroundTruth> truth = ReadGroundTruth(*file);
  if (!truth.ok()) return truth.error();
  return std::optional(std::move(*truth));
}

constexpr SequenceFormat kFormats[] = {
    {"plumbline", "Plumbline's own layout", "a folder with camera.json and color/ or tracks.csv",
     ProbePlumblineSequence, OpenPlumblineSequence, WritePlumblineSequence, TruthOfPlumbline},
    {"asl", "the ASL layout of EuRoC and TUM-VI", "a folder with mav0/cam0/data.csv",
     ProbeAslSequence, OpenAslSequence, WriteAslSequence, nullptr},
    {"7-scenes", "7-Scenes", "a folder with frame-NNNNNN.color.png", ProbeSevenScenes,
     OpenSevenScenes, nullptr, nullptr},
    {"icl-nuim", "ICL-NUIM", "a folder with rgb/ and NAME.gt.freiburg", ProbeIclNuim, OpenIclNuim,
     nullptr, nullptr},
    {"tum-rgbd", "TUM RGB-D", "a folder with rgb.txt", ProbeTumRgbd, OpenTumRgbd, WriteTumRgbd,
     nullptr},
    {"kitti-raw", "KITTI's raw data", "a folder with image_02/timestamps.txt", ProbeKittiRaw,
     OpenKittiRaw, nullptr, TruthOfKittiRaw},
    {"kitti-odometry", "KITTI's odometry benchmark",
     "a folder with calib.txt, times.txt and image_2/", ProbeKittiOdometry, OpenKittiOdometry,
     nullptr, nullptr},
    {"scannet", "ScanNet", "a file NAME.sens or a folder with color/, pose/ and intrinsic/",
     ProbeScanNet, OpenScanNet, nullptr, TruthOfScanNet},
    {"visma", "VISMA", "a folder with dataset and STAMP.png", ProbeVisma, OpenVisma, nullptr,
     TruthOfVisma},
    {"scenenn", "SceneNN", "a folder with image/imageNNNNN.png and trajectory.log", ProbeSceneNn,
     OpenSceneNn, nullptr, nullptr},
    {"bop", "a scene of BOP", "a folder with scene_camera.json and rgb/ or gray/", ProbeBop,
     OpenBop, nullptr, TruthOfBop},
    {"rosbag", "a ROS 1 bag", "a file NAME.bag", ProbeRosBag, OpenRosBag, nullptr, nullptr},
};

}  // namespace

std::span<const SequenceFormat> SequenceFormats() { return kFormats; }

Result<std::optional<GroundTruth>> ReadTruthOf(const Sequence& sequence,
                                               std::vector<std::string>& warnings,
                                               const ModelFrames& models) {
  const SequenceFormat* format = FindSequenceFormat(sequence.path());
  if (format == nullptr || format->truth == nullptr) return std::optional<GroundTruth>();
  return format->truth(sequence, models, warnings);
}

const SequenceFormat* FindSequenceFormat(const std::filesystem::path& path) {
  const SequenceFormat* best = nullptr;
  Likeness surest = Likeness::kNone;
  for (const SequenceFormat& format : kFormats) {
    const Likeness likeness = format.probe(path);
    if (likeness <= surest) continue;
    surest = likeness;
    best = &format;
  }
  return best;
}

}  // namespace plumbline
