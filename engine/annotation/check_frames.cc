// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/check_frames.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/annotation/pose_exchange.h"
#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

constexpr int kProbes = 48;  ///< Points of the model that stand for it.
constexpr float kMargin_m = 0.03f, kOwnScan_m = 0.06f;

struct Candidate {
  CheckFrame view;
  Eigen::Vector3d direction{0, 0, 0};  ///< From the model's middle to the camera.
  double quality = 0;
  cv::Rect box;  ///< Of the model in the image.
};

class Chooser {
 public:
  Chooser(const Sequence& sequence, const AnnotationDocument& document, const OutlineModel& model,
          const Eigen::Isometry3d& scan_from_object, const Occluders& occluders,
          const CheckFrameOptions& options)
      : sequence_(sequence),
        document_(document),
        model_(model),
        scan_from_object_(scan_from_object),
        occluders_(occluders),
        options_(options),
        upright_(UprightFrame(document.gravity_in_scan).upright_rotation()) {}

  Result<std::vector<CheckFrame>> Run(const WorkContext& work) const {
    std::vector<Candidate> candidates;
    const FrameSelection& among = options_.among;
    const int end = std::min(among.end.value_or(sequence_.num_frames()), sequence_.num_frames());
    const int count = std::max(0, end - among.first + among.step - 1) / among.step;
    const int step = std::max(1, (count + options_.max_candidates - 1) / options_.max_candidates);
    for (int frame = among.first; frame < end; frame += step * among.step) {
      if (work.stop.stop_requested()) return Cancelled();
      if (auto candidate = Look(frame)) candidates.push_back(std::move(*candidate));
    }
    double most_visible = 0;
    for (const Candidate& candidate : candidates) {
      most_visible = std::max(most_visible, candidate.view.visible);
    }
    std::erase_if(candidates, [&](const Candidate& candidate) {
      return candidate.view.visible < options_.min_of_best * most_visible;
    });
    std::vector<CheckFrame> chosen;
    for (const Candidate& candidate : Spread(candidates)) {
      if (work.stop.stop_requested()) return Cancelled();
      chosen.push_back(Sharpest(candidate));
      work.report({"choosing frames", static_cast<int>(chosen.size()), options_.frames});
    }
    return chosen;
  }

 private:
  static Error Cancelled() { return {ErrorCode::kCancelled, "choosing frames was cancelled"}; }

  /// Nothing where the model does not show well enough.
  std::optional<Candidate> Look(int frame) const {
    const auto scan_from_cam = ScanFromCam(document_, sequence_, frame);
    if (!scan_from_cam) return std::nullopt;
    const PinholeCamera& camera = sequence_.camera();
    const Eigen::Isometry3f cam_from_object =
        (scan_from_cam->inverse() * scan_from_object_).cast<float>();
    const Eigen::Vector3f center = cam_from_object * model_.center();
    const double size_px = 2 * camera.fx * model_.radius() / std::max(center.z(), 0.1f);
    if (center.z() < 0.1f || size_px < options_.min_size_px) return std::nullopt;
    const OcclusionTest others(occluders_, model_, scan_from_object_, *scan_from_cam, kMargin_m,
                               kOwnScan_m);
    int inside = 0, visible = 0;
    Eigen::AlignedBox2f box;
    const std::size_t vertices = model_.vertices().size();
    for (std::size_t i = 0; i < kProbes; ++i) {
      const Eigen::Vector3f point = cam_from_object * model_.vertices()[i * vertices / kProbes];
      if (point.z() < 0.1f) continue;
      const Eigen::Vector2f pixel = camera.Project(point.cast<double>()).cast<float>();
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > static_cast<float>(camera.width - 1) ||
          pixel.y() > static_cast<float>(camera.height - 1)) {
        continue;
      }
      ++inside;
      box.extend(pixel);
      visible += !others.Hides(point.head<2>() / point.z(), point.z());
    }
    if (inside < options_.min_inside * kProbes || visible < options_.min_visible * kProbes) {
      return std::nullopt;
    }
    return Describe(frame, *scan_from_cam, static_cast<double>(visible) / kProbes, box);
  }

  /// How far the model's middle moves in the image from the frame before or to the one after, in
  /// shares of the width: what moves fast is blurred.
  double Speed(int frame, const Eigen::Isometry3d& scan_from_cam) const {
    const Eigen::Vector3d center = scan_from_object_ * model_.center().cast<double>();
    const Eigen::Vector3d now = scan_from_cam.inverse() * center;
    double speed = 0;
    for (const int other : {frame - 1, frame + 1}) {
      if (other < 0 || other >= sequence_.num_frames()) continue;
      const auto scan_from_other = ScanFromCam(document_, sequence_, other);
      if (!scan_from_other) continue;
      const Eigen::Vector3d then = scan_from_other->inverse() * center;
      if (then.z() < 0.1 || now.z() < 0.1) continue;
      const PinholeCamera& camera = sequence_.camera();
      speed = std::max(speed, (camera.Project(now) - camera.Project(then)).norm() / camera.width);
    }
    return speed;
  }

  Candidate Describe(int frame, const Eigen::Isometry3d& scan_from_cam, double visible,
                     const Eigen::AlignedBox2f& box) const {
    const Eigen::Vector3d to_camera =
        scan_from_cam.translation() - scan_from_object_ * model_.center().cast<double>();
    const Eigen::Vector3d leveled = upright_.transpose() * to_camera;
    Candidate candidate;
    candidate.view = {frame, visible, to_camera.norm(), std::atan2(leveled.y(), leveled.x())};
    candidate.direction = to_camera.normalized();
    // Beyond a third of the image more size tells little more. A hundredth of the width from frame
    // to frame blurs by several pixels.
    const double share = box.sizes().maxCoeff() / static_cast<float>(sequence_.camera().width);
    candidate.quality =
        visible * std::sqrt(std::min(1.0, 3 * share)) / (1 + Speed(frame, scan_from_cam) / 0.01);
    candidate.box = cv::Rect(
        cv::Point(static_cast<int>(box.min().x()), static_cast<int>(box.min().y())),
        cv::Point(static_cast<int>(box.max().x()) + 1, static_cast<int>(box.max().y()) + 1));
    return candidate;
  }

  static double Apart(const Candidate& a, const Candidate& b) {
    const double turn = std::acos(std::clamp(a.direction.dot(b.direction), -1.0, 1.0));
    return turn + 0.5 * std::abs(std::log(a.view.distance_m / b.view.distance_m));
  }

  /// The best first, then always the one that is both good and far from those chosen.
  std::vector<Candidate> Spread(const std::vector<Candidate>& candidates) const {
    constexpr double kSame = 0.03;  // Closer than 2 degrees there is nothing new to see.
    std::vector<Candidate> chosen;
    std::vector<double> apart(candidates.size(), 1e3);
    while (static_cast<int>(chosen.size()) < options_.frames) {
      std::size_t best = candidates.size();
      double best_value = 0;
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        const double value = candidates[i].quality * apart[i];
        if (apart[i] < kSame || value <= best_value) continue;
        best_value = value;
        best = i;
      }
      if (best == candidates.size()) break;
      chosen.push_back(candidates[best]);
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        apart[i] = std::min(apart[i], Apart(candidates[i], candidates[best]));
      }
    }
    return chosen;
  }

  /// The frame next to the chosen one whose image is sharpest where the model is.
  CheckFrame Sharpest(const Candidate& candidate) const {
    CheckFrame best = candidate.view;
    double best_sharpness = -1;
    const int last = sequence_.num_frames() - 1;
    for (int d = 0; d <= 2 * options_.sharpness_window; ++d) {
      const int frame = candidate.view.frame + (d % 2 == 1 ? (d + 1) / 2 : -d / 2);
      if (frame < 0 || frame > last || !options_.among.Has(frame) ||
          !sequence_.world_from_cam(frame))
        continue;
      const Result<Frame> read = sequence_.ReadFrame(frame);
      if (!read) continue;
      const cv::Rect box = candidate.box & cv::Rect(0, 0, read->image.cols, read->image.rows);
      if (box.empty()) continue;
      cv::Mat gray, laplacian;
      cv::cvtColor(read->image(box), gray, cv::COLOR_BGR2GRAY);
      cv::Laplacian(gray, laplacian, CV_32F);
      const double sharpness = cv::norm(laplacian, cv::NORM_L1) / box.area();
      if (sharpness <= best_sharpness) continue;
      best_sharpness = sharpness;
      best.frame = frame;
    }
    return best;
  }

  const Sequence& sequence_;
  const AnnotationDocument& document_;
  const OutlineModel& model_;
  Eigen::Isometry3d scan_from_object_;
  const Occluders& occluders_;
  const CheckFrameOptions& options_;
  Eigen::Matrix3d upright_;
};

}  // namespace

Result<std::vector<CheckFrame>> ChooseCheckFrames(
    const Sequence& sequence, const AnnotationDocument& document, const OutlineModel& model,
    const Eigen::Isometry3d& scan_from_object, const Occluders& occluders,
    const CheckFrameOptions& options, const WorkContext& work) {
  return Chooser(sequence, document, model, scan_from_object, occluders, options).Run(work);
}

Result<std::shared_ptr<const AnnotationImages>> LoadCheckImages(
    const std::shared_ptr<const Sequence>& sequence, const AnnotationDocument& document,
    const OutlineModel& model, const Eigen::Isometry3d& scan_from_object,
    const Occluders& occluders, const CheckFrameOptions& options, const std::string& edges,
    const WorkContext& work) {
  const auto frames =
      ChooseCheckFrames(*sequence, document, model, scan_from_object, occluders, options, work);
  if (!frames) return frames.error();
  if (frames->empty()) return std::shared_ptr<const AnnotationImages>();
  std::vector<int> indices;
  for (const CheckFrame& frame : *frames) indices.push_back(frame.frame);
  return AnnotationImages::Load(sequence, document, indices, edges, work);
}

}  // namespace plumbline
