// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/boxes_picture.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace plumbline {

void DrawBoxes(std::span<const Detection> boxes, cv::Mat& picture) {
  const std::array<cv::Scalar, 6> colors = {
      cv::Scalar(205, 120, 30), {60, 140, 230}, {90, 160, 60},
      {160, 80, 190},           {60, 60, 210},  {130, 130, 40}};
  std::vector<std::string> categories;  // in the order of their best box
  constexpr double kTextSize = 0.45;
  for (const auto& [box, category, score] : boxes) {
    auto known = std::find(categories.begin(), categories.end(), category);
    if (known == categories.end()) known = categories.insert(categories.end(), category);
    const cv::Scalar& color =
        colors[static_cast<std::size_t>(known - categories.begin()) % colors.size()];
    const cv::Point corner(cvRound(box.x0), cvRound(box.y0));
    cv::rectangle(picture, corner, {cvRound(box.x1), cvRound(box.y1)}, color, 2, cv::LINE_AA);
    char text[80];
    std::snprintf(text, sizeof(text), "%s %.2f", category.c_str(), static_cast<double>(score));
    int below = 0;
    const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kTextSize, 1, &below);
    // Inside of the picture, above the box where there is room.
    const int left = std::clamp(corner.x, 0, std::max(0, picture.cols - size.width - 6));
    const int bottom = std::max(corner.y, size.height + below + 4);
    cv::rectangle(picture, {left, bottom - size.height - below - 4},
                  {left + size.width + 6, bottom}, color, cv::FILLED);
    cv::putText(picture, text, {left + 3, bottom - below - 1}, cv::FONT_HERSHEY_SIMPLEX, kTextSize,
                {255, 255, 255}, 1, cv::LINE_AA);
  }
}

}  // namespace plumbline
