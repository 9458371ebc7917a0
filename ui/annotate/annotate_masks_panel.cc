// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ui/annotate/annotate_panels.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/image_canvas.h"
#include "ui/framework/theme.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

/// The dimmed image with each object's pixels in the colour of its row.
cv::Mat InstancesPicture(const cv::Mat& image, const cv::Mat& instances) {
  cv::Mat picture;
  image.convertTo(picture, CV_8UC3, 0.5);
  if (instances.size() != image.size()) return picture;
  for (int y = 0; y < picture.rows; ++y) {
    const auto* at = instances.ptr<std::uint16_t>(y);
    auto* out = picture.ptr<cv::Vec3b>(y);
    for (int x = 0; x < picture.cols; ++x) {
      if (at[x] == 0) continue;
      const bool edge = x + 1 < picture.cols && at[x + 1] != at[x];
      const cv::Vec3b color = BgrOf(SeriesColor(static_cast<std::size_t>(at[x] - 1)));
      for (int c = 0; c < 3; ++c)
        out[x][c] = edge ? color[c] : cv::saturate_cast<std::uint8_t>(out[x][c] + 0.5 * color[c]);
    }
  }
  return picture;
}

class AnnotateMasksPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink& sink) override {
    const AnnotationSnapshot& snapshot = *context.annotation;
    if (snapshot.num_frames == 0) return;
    int frame = snapshot.frame ? snapshot.frame->frame : 0;
    ImGui::SetNextItemWidth(context.Scaled(280));
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {context.Scaled(4), context.Scaled(1)});
    // The number stands beside the slider: on it, its handle would hide it.
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0, 0, 0, 0));
    const bool moved = ImGui::SliderInt("##masks.frame", &frame, 0, snapshot.num_frames - 1, "%d");
    ImGui::PopStyleColor();
    ImGui::PopStyleVar();
    LogItem(context, "masks.frame");
    if (moved) sink.Post(ShowFrameCommand{frame, true});
    Tooltip(context, "Which frame is shown.");
    ImGui::SameLine();
    DimText("%d of %d", frame, snapshot.num_frames - 1);
    ImGui::SameLine(0, context.Scaled(14));
    bool close = false;
    if (Toggle(context, "masks.close", "Back to the images", close,
               "The selected object's outline in key frames."))
      context.annotate->masks = false;
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    const AnnotationSnapshot& snapshot = *context.annotation;
    Ask(snapshot, sink);
    if (!snapshot.frame || (snapshot.frame->image.empty() && snapshot.frame->problem.empty()))
      return EmptyState(context, "Reading a frame", "");
    const FrameView& frame = *snapshot.frame;
    if (frame.image.empty()) return EmptyState(context, "No image", frame.problem.c_str());
    const ImTextureID texture = context.textures->Get("annotate_masks", snapshot.frame_number, [&] {
      return InstancesPicture(frame.image, frame.instances);
    });
    const ImageCanvas canvas(context, "masks.view", texture, snapshot.frame_size.x(),
                             snapshot.frame_size.y());
    PictureLabels labels(context, canvas.low(), canvas.high());
    if (!frame.masks_problem.empty())
      labels.Add({canvas.low()}, colors::kWarning, frame.masks_problem);
    const auto pixel = canvas.hovered();
    const AnnotatedInstance* instance = pixel ? At(snapshot, *pixel) : nullptr;
    if (instance != nullptr) {
      PutTooltipBesideMouse(context);
      ImGui::SetTooltip("%s", instance->id.c_str());
    }
    if (canvas.clicked()) sink.Post(SelectInstanceCommand{instance != nullptr ? instance->id : ""});
  }

 private:
  /// For the frame, and again once something has moved.
  void Ask(const AnnotationSnapshot& snapshot, CommandSink& sink) {
    std::string ids;
    std::vector<double> poses = {static_cast<double>(snapshot.models->size())};
    for (const AnnotatedInstance& instance : snapshot.instances) {
      ids += instance.id + "/" + instance.model + "\n";
      const double* pose = instance.scan_from_object.data();
      poses.insert(poses.end(), pose, pose + 16);
      poses.push_back(instance.scale);
    }
    // Elsewhere frames are read without their masks.
    const bool without = snapshot.frame && !snapshot.frame->masks &&
                         std::exchange(asked_at_, snapshot.frame_number) != snapshot.frame_number;
    if (snapshot.frame && !without && ids == ids_ && poses == poses_) return;
    if (!snapshot.frame && asked_of_ == snapshot.project_file) return;
    asked_of_ = snapshot.project_file;
    ids_ = ids;
    poses_ = poses;
    sink.Post(
        ShowFrameCommand{snapshot.frame ? snapshot.frame->frame : snapshot.num_frames / 2, true});
  }

  static const AnnotatedInstance* At(const AnnotationSnapshot& snapshot,
                                     const Eigen::Vector2f& pixel) {
    const cv::Mat& map = snapshot.frame->instances;
    const int x = static_cast<int>(pixel.x() + 0.5f), y = static_cast<int>(pixel.y() + 0.5f);
    if (x < 0 || y < 0 || x >= map.cols || y >= map.rows) return nullptr;
    const std::size_t place = map.at<std::uint16_t>(y, x);
    return place > 0 && place <= snapshot.instances.size() ? &snapshot.instances[place - 1]
                                                           : nullptr;
  }

  std::optional<std::uint64_t> asked_at_;  ///< Frame number without masks, asked for again.
  std::string ids_, asked_of_;
  std::vector<double> poses_;  ///< As of the last question.
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateMasksPanel() { return std::make_unique<AnnotateMasksPanel>(); }

}  // namespace plumbline
