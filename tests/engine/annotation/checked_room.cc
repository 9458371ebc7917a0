// SPDX-License-Identifier: Apache-2.0
#include "tests/engine/annotation/checked_room.h"

#include <cmath>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "engine/annotation/outline_projection.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

class Arc : public Sequence {
 public:
  Arc(int frames, double arc_deg, double distance_m) : camera_(TestCamera()) {
    calibration_.cameras = {{"cam", {}}};
    calibration_.cameras[0].camera.pinhole = camera_;
    for (int i = 0; i < frames; ++i) {
      const double angle = arc_deg * std::numbers::pi / 180 * i / std::max(1, frames - 1);
      poses_.push_back(
          LookAt({distance_m * std::cos(angle), distance_m * std::sin(angle), 1.4}, {0, 0, 0.4}));
    }
  }

  const std::filesystem::path& path() const override { return path_; }
  int num_frames() const override { return static_cast<int>(poses_.size()); }
  const PinholeCamera& camera() const override { return camera_; }
  const Calibration& calibration() const override { return calibration_; }
  double rate_hz() const override { return 30; }
  std::int64_t stamp_ns(int index) const override { return index * 33'000'000LL; }
  std::optional<Eigen::Isometry3d> world_from_cam(int index) const override {
    return poses_[static_cast<std::size_t>(index)];
  }
  std::optional<Eigen::Vector3d> gravity_in_world() const override {
    return Eigen::Vector3d(0, 0, -1);
  }
  std::optional<Eigen::Vector4d> floor_in_world() const override { return std::nullopt; }
  Result<Frame> ReadFrame(int index) const override {
    if (index == 0) return Error{ErrorCode::kCorrupt, "'arc/000000.png' is torn"};
    cv::Mat image(camera_.height, camera_.width, CV_8UC3, cv::Scalar::all(40));
    cv::rectangle(image, {200, 150, 240, 180}, cv::Scalar::all(200), cv::FILLED);
    return Frame{index, stamp_ns(index), image, world_from_cam(index)};
  }
  Result<cv::Mat> ReadRawImage(int index) const override {
    Result<Frame> frame = ReadFrame(index);
    if (!frame.ok()) return frame.error();
    return frame->image;
  }
  Result<std::optional<cv::Mat>> ReadDepth(int) const override { return std::optional<cv::Mat>{}; }
  Result<ImuRecording> ReadImu() const override { return ImuRecording(); }
  Result<std::optional<EdgeMap>> ReadEdges(int) const override { return std::optional<EdgeMap>{}; }
  Result<std::optional<std::vector<Detection>>> ReadProposals(int) const override {
    return std::optional<std::vector<Detection>>{};
  }
  bool has_images() const override { return true; }
  bool has_imu() const override { return false; }
  bool has_depth() const override { return false; }
  bool has_edges() const override { return false; }
  bool has_proposals() const override { return false; }
  std::optional<std::filesystem::path> scene_file() const override { return std::nullopt; }
  std::optional<std::filesystem::path> ground_truth_file() const override { return std::nullopt; }
  std::optional<std::filesystem::path> models_folder() const override { return std::nullopt; }
  std::optional<std::filesystem::path> tracks_file() const override { return std::nullopt; }
  std::optional<std::filesystem::path> reference_file() const override { return std::nullopt; }
  const std::vector<std::string>& warnings() const override { return warnings_; }

 private:
  PinholeCamera camera_;
  Calibration calibration_;
  std::filesystem::path path_ = "arc";
  std::vector<std::string> warnings_;
  std::vector<Eigen::Isometry3d> poses_;
};

TriangleMesh Moved(const TriangleMesh& mesh, const Eigen::Vector3d& by) {
  return Transformed(mesh, Eigen::Isometry3d(Eigen::Translation3d(by)));
}

}  // namespace

TriangleMesh BoxMesh(const Eigen::Vector3f& size) {
  const Eigen::Vector3f half(size.x() / 2, size.y() / 2, 0);
  return MakeBox(-half, half + Eigen::Vector3f(0, 0, size.z()));
}

TriangleMesh SeatMesh() {
  TriangleMesh mesh = BoxMesh({0.5f, 0.45f, 0.4f});
  Append(Moved(BoxMesh({0.06f, 0.45f, 0.5f}), {-0.22, 0, 0.4}), mesh);
  Append(Moved(BoxMesh({0.3f, 0.06f, 0.2f}), {0.0, 0.19, 0.4}), mesh);
  return mesh;
}

Eigen::Isometry3d LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  Eigen::Isometry3d scan_from_cam = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  scan_from_cam.linear() << right, forward.cross(right), forward;
  scan_from_cam.translation() = eye;
  return scan_from_cam;
}

PinholeCamera TestCamera() { return {640, 480, 554, 554, 319.5, 239.5}; }

std::shared_ptr<const Sequence> ArcSequence(int frames, double arc_deg, double distance_m) {
  return std::make_shared<Arc>(frames, arc_deg, distance_m);
}

AnnotationImage DrawnImage(int frame, const OutlineModel& model,
                           const Eigen::Isometry3d& scan_from_object,
                           const Eigen::Isometry3d& scan_from_cam, const Occluders& occluders) {
  OutlineOptions options;
  options.step_px = 0.5;
  const PinholeCamera camera = TestCamera();
  AnnotationImage image{frame, {}, {}, scan_from_cam};
  image.edges.probability = cv::Mat::zeros(camera.height, camera.width, CV_8U);
  image.edges.angle = cv::Mat::zeros(camera.height, camera.width, CV_8U);
  const ModelOutline outline =
      ProjectOutline(model, scan_from_object, scan_from_cam, camera, occluders, options);
  for (const OutlineSample& sample : outline.samples) {
    if (sample.hidden) continue;
    const int x = static_cast<int>(std::lround(sample.pixel.x()));
    const int y = static_cast<int>(std::lround(sample.pixel.y()));
    const double angle = std::atan2(sample.normal.y(), sample.normal.x());
    image.edges.probability.at<std::uint8_t>(y, x) = 255;
    image.edges.angle.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(
        static_cast<int>(std::lround((angle + 2 * std::numbers::pi) * 256 / std::numbers::pi)) %
        256);
  }
  return image;
}

}  // namespace plumbline
