// SPDX-License-Identifier: Apache-2.0
#include "tests/support/simulated_sequence.h"

#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

class Simulated : public Sequence {
 public:
  explicit Simulated(SimulatedRecording recording) : recording_(std::move(recording)) {
    calibration_.cameras = {{"cam", recording_.camera}};
    calibration_.imu = recording_.imu;
  }

  const fs::path& path() const override { return path_; }
  int num_frames() const override { return static_cast<int>(recording_.images.size()); }
  const PinholeCamera& camera() const override { return recording_.camera.pinhole; }
  const Calibration& calibration() const override { return calibration_; }
  double rate_hz() const override { return recording_.camera.rate_hz; }
  std::int64_t stamp_ns(int index) const override {
    return recording_.images[static_cast<std::size_t>(index)].stamp_ns;
  }
  std::optional<Eigen::Isometry3d> world_from_cam(int index) const override {
    if (!recording_.camera.body_from_cam) return std::nullopt;
    return recording_.truth[static_cast<std::size_t>(index)].world_from_body *
           *recording_.camera.body_from_cam;
  }
  std::optional<Eigen::Vector3d> gravity_in_world() const override {
    return Eigen::Vector3d(0, 0, -1);
  }
  std::optional<Eigen::Vector4d> floor_in_world() const override {
    return Eigen::Vector4d(0, 0, 1, 0);
  }
  Result<Frame> ReadFrame(int index) const override {
    return Frame{index, stamp_ns(index), Drawn(index), world_from_cam(index)};
  }
  Result<cv::Mat> ReadRawImage(int index) const override { return Drawn(index); }
  Result<std::optional<cv::Mat>> ReadDepth(int) const override { return std::optional<cv::Mat>(); }
  Result<std::optional<EdgeMap>> ReadEdges(int) const override { return std::optional<EdgeMap>(); }
  Result<std::optional<std::vector<Detection>>> ReadProposals(int) const override {
    return std::optional<std::vector<Detection>>();
  }
  Result<ImuRecording> ReadImu() const override {
    ImuRecording imu;
    imu.samples = recording_.samples;
    return imu;
  }
  bool has_images() const override { return true; }
  bool has_imu() const override { return !recording_.samples.empty(); }
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
  /// Patches of 13 pixels, blurred a little, which corners are found in and followed by.
  cv::Mat Drawn(int index) const {
    constexpr int kHalf = 6;
    cv::Mat image(480, 640, CV_8UC3, cv::Scalar::all(90));
    for (const TrackedPoint& point : recording_.images[static_cast<std::size_t>(index)].points) {
      Random random({static_cast<std::uint64_t>(point.id) + 1});
      cv::Mat patch(2 * kHalf + 1, 2 * kHalf + 1, CV_8UC3);
      for (int y = 0; y <= 2 * kHalf; ++y) {
        for (int x = 0; x <= 2 * kHalf; ++x) {
          if (x % 4 == 0 && y % 4 == 0) {
            const auto grey = static_cast<double>(random.Index(256));
            cv::rectangle(patch, {x, y}, {x + 3, y + 3}, cv::Scalar::all(grey), cv::FILLED);
          }
        }
      }
      const cv::Point corner(static_cast<int>(point.pixel.x()) - kHalf - 1,
                             static_cast<int>(point.pixel.y()) - kHalf - 1);
      const cv::Rect place(corner, cv::Size(2 * kHalf + 3, 2 * kHalf + 3));
      if ((place & cv::Rect({0, 0}, image.size())) != place) continue;  // half outside
      cv::Mat part = image(place);
      const cv::Matx23d shift(1, 0, point.pixel.x() - kHalf - corner.x, 0, 1,
                              point.pixel.y() - kHalf - corner.y);
      cv::warpAffine(patch, part, shift, part.size(), cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
    }
    return image;
  }

  SimulatedRecording recording_;
  Calibration calibration_;
  fs::path path_ = "simulated";
  std::vector<std::string> warnings_;
};

}  // namespace

std::shared_ptr<const Sequence> SimulatedSequence(SimulatedRecording recording) {
  return std::make_shared<const Simulated>(std::move(recording));
}

}  // namespace plumbline
