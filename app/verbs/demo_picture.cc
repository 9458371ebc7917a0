// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/demo_picture.h"

#include <algorithm>
#include <cstdio>

#include <opencv2/imgproc.hpp>

#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

const cv::Scalar kInk(235, 235, 230), kFaint(150, 145, 140), kGround(38, 34, 31);
constexpr double kFarthest_m = 6.0;

cv::Scalar BgrOf(const ObjectLooks& looks, ObjectId object) {
  const auto look = looks.find(object);
  const LookColor color = ColorOf(look != looks.end() ? look->second : ObjectLook());
  return {static_cast<double>(color.blue), static_cast<double>(color.green),
          static_cast<double>(color.red)};
}

void Text(cv::Mat& picture, const std::string& text, cv::Point at, double size,
          const cv::Scalar& color) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_DUPLEX, size, color, 1, cv::LINE_AA);
}

cv::Mat WithObjects(const MapSnapshot& snapshot, const ObjectLooks& looks, cv::Size size) {
  cv::Mat picture;
  cv::resize(snapshot.image, picture, size, 0, 0, cv::INTER_AREA);
  const double scale = static_cast<double>(size.width) / snapshot.image.cols;
  for (const ProposalReport& proposal : snapshot.report.proposals) {
    const cv::Point a(cvRound(proposal.box.x0 * scale), cvRound(proposal.box.y0 * scale));
    const cv::Point b(cvRound(proposal.box.x1 * scale), cvRound(proposal.box.y1 * scale));
    cv::rectangle(picture, a, b, kFaint, 1, cv::LINE_AA);
  }
  for (const ObjectReport& object : snapshot.report.objects) {
    if (object.state != ObjectState::kConfirmed || snapshot.id.empty()) continue;
    cv::Mat mask;
    cv::resize(snapshot.id == object.id.value, mask, size, 0, 0, cv::INTER_LINEAR);
    std::vector<std::vector<cv::Point>> outline;
    cv::findContours(mask > 127, outline, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
    cv::drawContours(picture, outline, -1, BgrOf(looks, object.id), 2, cv::LINE_AA);
  }
  return picture;
}

cv::Mat DepthPicture(const MapSnapshot& snapshot, cv::Size size) {
  cv::Mat picture(size, CV_8UC3, kGround);
  if (snapshot.depth.empty()) return picture;
  cv::Mat depth, nearness, colored;
  cv::resize(snapshot.depth, depth, size, 0, 0, cv::INTER_NEAREST);
  depth.convertTo(nearness, CV_8U, -255.0 / kFarthest_m, 255.0);
  cv::applyColorMap(nearness, colored, cv::COLORMAP_VIRIDIS);
  colored.copyTo(picture, depth > 0);
  return picture;
}

cv::Mat MaskPicture(const MapSnapshot& snapshot, const ObjectLooks& looks, cv::Size size) {
  cv::Mat picture;
  cv::resize(snapshot.image, picture, size, 0, 0, cv::INTER_AREA);
  if (snapshot.id.empty()) return picture;
  cv::Mat id, depth;
  cv::resize(snapshot.id, id, size, 0, 0, cv::INTER_NEAREST);
  cv::resize(snapshot.depth, depth, size, 0, 0, cv::INTER_NEAREST);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (id.at<std::uint16_t>(y, x) == 0) continue;
      const double far = std::clamp(depth.at<float>(y, x) / kFarthest_m, 0.0, 1.0);
      const cv::Scalar color = BgrOf(looks, {id.at<std::uint16_t>(y, x)}) * (0.35 + 0.65 * far);
      cv::Vec3b& pixel = picture.at<cv::Vec3b>(y, x);
      for (int c = 0; c < 3; ++c)
        pixel[c] = cv::saturate_cast<std::uint8_t>(0.35 * pixel[c] + 0.65 * color[c]);
    }
  }
  return picture;
}

void ListObjects(const MapSnapshot& snapshot, const ModelDatabase& database,
                 const ObjectLooks& looks, cv::Mat picture) {
  char line[160];
  int tentative = 0, row = 0;
  for (const ObjectReport& object : snapshot.report.objects) {
    if (object.state == ObjectState::kTentative) ++tentative;
    if (object.state != ObjectState::kConfirmed) continue;
    const int x = 24 + (row / 7) * 470, y = 66 + (row % 7) * 25;
    if (row++ >= 14) continue;
    cv::circle(picture, {x + 6, y - 5}, 6, BgrOf(looks, object.id), cv::FILLED, cv::LINE_AA);
    Text(picture, database.model(object.label).name, {x + 22, y}, 0.5, kInk);
    std::snprintf(line, sizeof(line), "+-%.1f cm  %s", 100 * object.modes.front().position_std_m,
                  object.updated ? "in view" : "remembered");
    Text(picture, line, {x + 235, y}, 0.5, object.updated ? kInk : kFaint);
  }
  std::snprintf(line, sizeof(line), "Frame %d    %d objects in the map, %d more under test",
                snapshot.report.frame, row, tentative);
  Text(picture, line, {24, 34}, 0.62, kInk);
}

}  // namespace

cv::Mat DemoPicture(const MapSnapshot& snapshot, const ModelDatabase& database,
                    const ObjectLooks& looks) {
  cv::Mat picture(kDemoPictureSize, CV_8UC3, kGround);
  if (snapshot.image.empty()) return picture;
  const cv::Rect main(0, 0, 960, 500), list(0, 500, 960, 250);
  WithObjects(snapshot, looks, main.size()).copyTo(picture(main));
  ListObjects(snapshot, database, looks, picture(list));
  cv::Mat edges;
  cv::resize(snapshot.edge_probability, edges, {480, 250}, 0, 0, cv::INTER_AREA);
  cv::cvtColor(edges * 2, edges, cv::COLOR_GRAY2BGR);
  const cv::Mat column[] = {edges, DepthPicture(snapshot, {480, 250}),
                            MaskPicture(snapshot, looks, {480, 250})};
  static constexpr const char* kNames[] = {"edges", "Z-buffer of the map (bright: near)",
                                           "masks (dark: near)"};
  for (int i = 0; i < 3; ++i) {
    const cv::Rect place(960, 250 * i, 480, 250);
    column[i].copyTo(picture(place));
    cv::rectangle(picture, place, kGround, 2);
    cv::Mat corner = picture({960, 250 * i, 330, 26});
    corner *= 0.35;
    Text(picture, kNames[i], {970, 250 * i + 18}, 0.48, kInk);
  }
  return picture;
}

}  // namespace plumbline
