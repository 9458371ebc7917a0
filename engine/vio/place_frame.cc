// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/place_frame.h"

#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/angles.h"
#include "engine/vio/point_view.h"

namespace plumbline {
namespace {

constexpr double kScale = 1.2;  ///< Between levels of ORB's pyramid.
constexpr int kLevels = 8, kFastThreshold = 10, kPatch = 31;
/// Tracked points are described at these levels, so that they are known again from nearer by.
constexpr int kPointLevels[] = {0, 2, 4};
/// Corners carry this; tracked points their index.
constexpr int kNoTrack = -1;

cv::Mat GreyOf(const cv::Mat& picture) {
  if (picture.channels() == 1) return picture;
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

}  // namespace

std::size_t PlaceFrame::bytes() const {
  return sizeof(PlaceFrame) + corners.size() * sizeof(PlaceCorner) + descriptors.total() +
         points_in_body.size() * sizeof(Eigen::Vector3d) + point_descriptors.total() +
         point_of_row.size() * sizeof(int);
}

void PlaceFrame::LetGo() {
  let_go = true;
  std::vector<PlaceCorner>().swap(corners);
  std::vector<Eigen::Vector3d>().swap(points_in_body);
  std::vector<int>().swap(point_of_row);
  descriptors.release();
  point_descriptors.release();
}

PlaceFrameMaker::PlaceFrameMaker(const Camera& camera, int corners)
    : camera_(camera),
      orb_(cv::ORB::create(corners, kScale, kLevels, kPatch / 2 + 4, 0, 2, cv::ORB::HARRIS_SCORE,
                           kPatch, kFastThreshold)) {}

double PlaceFrameMaker::GravityAngleDeg(const Eigen::Vector3d& ray_in_cam,
                                        const Eigen::Vector3d& down_in_cam) const {
  const auto projection = camera_.Project(ray_in_cam);
  if (!projection) return 0;
  const Eigen::Vector2d down = projection->pixel_by_point * down_in_cam;
  const double angle = std::atan2(down.y(), down.x()) * kDegPerRad;
  return angle < 0 ? angle + 360 : angle;
}

PlaceFrame PlaceFrameMaker::Make(const cv::Mat& picture, const TrackedImage& tracked, int image,
                                 const VioReport& report) {
  PlaceFrame key_frame;
  key_frame.image = image;
  key_frame.stamp_ns = report.stamp_ns;
  key_frame.stretch = report.stretch;
  key_frame.world_from_body = report.world_from_body;
  key_frame.covariance = report.covariance;
  key_frame.body_from_cam = report.body_from_cam;

  const cv::Mat grey = GreyOf(picture);
  std::vector<cv::KeyPoint> found;
  orb_->detect(grey, found);
  for (cv::KeyPoint& corner : found) corner.class_id = kNoTrack;
  for (std::size_t i = 0; i < tracked.points.size(); ++i) {
    for (const int level : kPointLevels) {
      const double size = std::pow(kScale, level);
      found.emplace_back(static_cast<float>(tracked.points[i].pixel.x()),
                         static_cast<float>(tracked.points[i].pixel.y()),
                         static_cast<float>(kPatch * size), 0.f, 0.f, level, static_cast<int>(i));
    }
  }
  const Eigen::Vector3d down_in_cam =
      (report.world_from_body * report.body_from_cam).linear().transpose() *
      Eigen::Vector3d(0, 0, -1);
  std::vector<cv::KeyPoint> kept;
  for (cv::KeyPoint& corner : found) {
    const Eigen::Vector2d pixel(corner.pt.x, corner.pt.y);
    const auto ray = camera_.Unproject(pixel);
    if (!ray) continue;
    corner.angle = static_cast<float>(GravityAngleDeg(*ray, down_in_cam));
    kept.push_back(corner);
  }
  cv::Mat descriptors;
  orb_->compute(grey, kept, descriptors);  // leaves out and reorders

  Waiting waiting{made_++, {}};
  for (int row = 0; row < static_cast<int>(kept.size()); ++row) {
    const cv::KeyPoint& corner = kept[static_cast<std::size_t>(row)];
    if (corner.class_id != kNoTrack) {
      const std::int64_t track = tracked.points[static_cast<std::size_t>(corner.class_id)].id;
      waiting.rows[track].push_back(descriptors.row(row).clone());
      continue;
    }
    const Eigen::Vector2d pixel(corner.pt.x, corner.pt.y);
    key_frame.corners.push_back(
        {pixel, *camera_.Unproject(pixel), std::pow(kScale, corner.octave)});
    key_frame.descriptors.push_back(descriptors.row(row));
  }
  waiting_.push_back(std::move(waiting));
  if (waiting_.size() > kWaitingKeyFrames) waiting_.erase(waiting_.begin());
  return key_frame;
}

void PlaceFrameMaker::Place(std::int64_t track, const Eigen::Vector3d& point_in_world,
                            Waiting& waiting, PlaceFrame& key_frame) {
  const auto found = waiting.rows.find(track);
  if (found == waiting.rows.end()) return;
  for (const cv::Mat& row : found->second) {
    key_frame.point_descriptors.push_back(row);
    key_frame.point_of_row.push_back(static_cast<int>(key_frame.points_in_body.size()));
  }
  key_frame.points_in_body.push_back(key_frame.world_from_body.inverse() * point_in_world);
  waiting.rows.erase(found);
}

void PlaceFrameMaker::AddPoints(std::span<const MapPoint> finished,
                                std::span<PlaceFrame> key_frames) {
  for (Waiting& waiting : waiting_) {
    PlaceFrame& key_frame = key_frames[waiting.key_frame];
    if (key_frame.stretch != key_frames.back().stretch) continue;  // of another world
    for (const MapPoint& point : finished)
      Place(point.track, point.point_in_world, waiting, key_frame);
  }
}

void PlaceFrameMaker::Renumber(std::size_t gone) {
  made_ -= gone;
  for (Waiting& waiting : waiting_) waiting.key_frame -= gone;
}

void PlaceFrameMaker::AddStatePoints(const FilterState& state, std::span<PlaceFrame> key_frames) {
  if (waiting_.empty()) return;
  Waiting& newest = waiting_.back();
  for (const StatePoint& point : state.points()) {
    const PoseClone* anchor = state.FindClone(point.anchor);
    if (anchor == nullptr || point.rejected > 0) continue;
    const AnchoredPoint placed =
        PlacePoint(state.body_from_cam(), anchor->world_from_body, point.bearing_and_inverse_depth);
    Place(point.track, placed.point_in_world, newest, key_frames[newest.key_frame]);
  }
}

}  // namespace plumbline
