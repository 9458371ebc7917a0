// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/model_sheet.h"

#include <cmath>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/render/small_picture.h"

namespace plumbline {
namespace {

constexpr int kWidth = 220, kHeight = 200, kText = 24, kColumns = 6;
const cv::Scalar kPaper(35, 29, 25), kInk(225, 225, 225), kChosen(224, 168, 82);

void Write(const std::string& text, int x, int baseline, const cv::Scalar& color,
           cv::Mat& picture) {
  cv::putText(picture, text, {x, baseline}, cv::FONT_HERSHEY_SIMPLEX, 0.5, color, 1, cv::LINE_AA);
}

/// The model with the file's axes `up` and `front` as +z and +x.
TriangleMesh TurnedTo(const BuiltModel& built, const SignedAxis& up, const SignedAxis& front) {
  Eigen::Matrix3d shown_from_file;
  shown_from_file << front.vector().transpose(), up.vector().cross(front.vector()).transpose(),
      up.vector().transpose();
  Eigen::Isometry3d shown_from_object = Eigen::Isometry3d::Identity();
  shown_from_object.linear() = shown_from_file * built.report.object_from_file.linear().transpose();
  return Transformed(built.model.mesh, shown_from_object);
}

/// Six ups or four fronts in one row under a heading.
cv::Mat Row(const BuiltModel& built, const std::string& heading, const std::string& option,
            const Settled<SignedAxis>& settled, bool is_up) {
  cv::Mat row(kHeight + 2 * kText, kColumns * kWidth, CV_8UC3, kPaper);
  Write(heading, 8, kText - 8, kInk, row);
  int column = 0;
  for (const auto& [axis, share] : settled.shares) {
    const SignedAxis up = is_up ? axis : built.report.up.value;
    const SignedAxis front = is_up ? SignedAxis{axis.axis == 0 ? 1 : 0, 1} : axis;
    const int left = column++ * kWidth;
    ModelPicture(TurnedTo(built, up, front), kWidth, kHeight)
        .copyTo(row(cv::Rect(left, kText, kWidth, kHeight)));
    Write(option + "=" + axis.text() + "   " + std::to_string(std::lround(100 * share)) + " %",
          left + 8, kHeight + 2 * kText - 8, axis == settled.value ? kChosen : kInk, row);
  }
  return row;
}

}  // namespace

void AddQuestions(const BuiltModel& built, std::vector<cv::Mat>& rows) {
  const ModelBuildReport& report = built.report;
  if (!report.up.sure())
    rows.push_back(
        Row(built, built.model.name + ": which stands upright?", "--up", report.up, true));
  if (!report.front.sure()) {
    rows.push_back(Row(built,
                       built.model.name + ": which shows its front (towards the lower left)?",
                       "--front", report.front, false));
  }
}

}  // namespace plumbline
