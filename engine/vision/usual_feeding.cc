// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/usual_feeding.h"

namespace plumbline {

std::string FeedAsUsual(NetworkSidecar& s) {
  const cv::Scalar rgb_mean(123.675, 116.28, 103.53), rgb_deviation(58.395, 57.12, 57.375);
  switch (s.kind) {
    case NetworkKind::kEdge:
      s.scale = 1 / 255.0;
      s.swap_rb = true;
      return "How it wants its values is not in the file: RGB from 0 to 1 is a guess.";
    case NetworkKind::kFastestDet:
      s.scale = 1 / 255.0;
      return "Fed as FastestDet is: stretched, BGR, 0 to 1.";
    case NetworkKind::kYolox:
      s.fit = ImageFit::kLetterbox;
      return "Fed as YOLOX since 0.1.1 is: in the upper left corner on grey, BGR, 0 to 255.";
    case NetworkKind::kYolov5:
    case NetworkKind::kYolov8:
    case NetworkKind::kYolov10:
      s.fit = ImageFit::kCentred;
      s.scale = 1 / 255.0;
      s.swap_rb = true;
      return "Fed as Ultralytics' networks are: in the middle on grey, RGB, 0 to 1.";
    case NetworkKind::kPicodet:
      s.mean = rgb_mean;
      s.deviation = rgb_deviation;
      s.swap_rb = true;
      return "Fed as PicoDet is: stretched, RGB, ImageNet's mean and deviation.";
    case NetworkKind::kNanodet:
      s.mean = {rgb_mean[2], rgb_mean[1], rgb_mean[0]};
      s.deviation = {rgb_deviation[2], rgb_deviation[1], rgb_deviation[0]};
      return "Fed as NanoDet is: stretched, BGR, ImageNet's mean and deviation.";
    case NetworkKind::kSsd:
      s.mean = cv::Scalar::all(127);
      s.scale = 1 / 128.0;
      s.swap_rb = true;
      return "Fed as SSD with MobileNet usually is: stretched, RGB, (value - 127) / 128.";
    case NetworkKind::kTwoStage:
      break;
  }
  return "How it is fed, its sidecar says.";
}

}  // namespace plumbline
