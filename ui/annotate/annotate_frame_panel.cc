// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <string>

#include "ui/annotate/annotate_panels.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/image_canvas.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr ImU32 kPicked = IM_COL32(120, 255, 160, 255), kSeen = IM_COL32(255, 210, 120, 255);

class AnnotateFramePanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink& sink) override {
    const AnnotationSnapshot& snapshot = *context.annotation;
    if (snapshot.num_frames == 0) return;
    int frame = snapshot.frame ? snapshot.frame->frame : 0;
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() - context.Scaled(2));
    ImGui::SetNextItemWidth(context.Scaled(320));
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {context.Scaled(4), context.Scaled(1)});
    // The number stands beside the slider: on it, its handle would hide it.
    if (!typing_) ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0, 0, 0, 0));
    const bool moved = ImGui::SliderInt("##frame.number", &frame, 0, snapshot.num_frames - 1, "%d");
    if (!typing_) ImGui::PopStyleColor();
    typing_ = ImGui::IsItemActive() && ImGui::GetIO().WantTextInput;
    if (moved) {
      context.annotate->pick_pixel.reset();
      sink.Post(ShowFrameCommand{frame});
    }
    ImGui::PopStyleVar();
    LogItem(context, "frame.number");
    Tooltip(context, "Which frame is shown; Ctrl and a click to type its number.");
    ImGui::SameLine();
    ImGui::TextDisabled("%d of %d", frame, snapshot.num_frames - 1);
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    const AnnotationSnapshot& snapshot = *context.annotation;
    if (!snapshot.frame) {
      if (asked_of_ != snapshot.project_file) sink.Post(ShowFrameCommand{snapshot.num_frames / 2});
      asked_of_ = snapshot.project_file;
      return EmptyState(context, "Reading a frame", "");
    }
    asked_of_.clear();
    const FrameView& frame = *snapshot.frame;
    if (frame.image.empty()) {
      return EmptyState(context, frame.problem.empty() ? "Reading a frame" : "No image",
                        frame.problem.c_str());
    }
    if (context.textures == nullptr) return;
    const ImTextureID texture =
        context.textures->Get("annotate_frame", snapshot.frame_number, [&] { return frame.image; });
    const ImageCanvas canvas(context, "frame.view", texture, snapshot.frame_size.x(),
                             snapshot.frame_size.y());
    if (const auto clicked = canvas.clicked()) Click(context, clicked->cast<double>(), sink);
    Mark(context, canvas, frame.frame);
  }

 private:
  static void Click(const FrameContext& context, const Eigen::Vector2d& pixel, CommandSink& sink) {
    AnnotateView& view = *context.annotate;
    if (view.pick_in_scan) {
      sink.Post(AddPairCommand{*view.pick_in_scan, context.annotation->frame->frame, pixel});
      view.pick_in_scan.reset();
      view.pick_pixel.reset();
    } else {
      view.pick_pixel = pixel;
    }
  }

  static void Mark(const FrameContext& context, const ImageCanvas& canvas, int frame) {
    PictureLabels labels(context, canvas.low(), canvas.high());
    const float size = context.Scaled(6);
    const auto cross = [&](const Eigen::Vector2d& pixel, ImU32 color) {
      const ImVec2 at = canvas.ToScreen(pixel.cast<float>());
      canvas.draw().AddLine({at.x - size, at.y}, {at.x + size, at.y}, color, context.Scaled(1.5f));
      canvas.draw().AddLine({at.x, at.y - size}, {at.x, at.y + size}, color, context.Scaled(1.5f));
      return at;
    };
    int number = 0;
    for (const PairView& pair : context.annotation->pairs) {
      ++number;
      if (pair.seen_at) {
        const ImVec2 at = canvas.ToScreen(pair.seen_at->cast<float>());
        canvas.draw().AddCircle(at, size, WithAlpha(kSeen, pair.frame == frame ? 1 : 0.4), 0,
                                context.Scaled(1.5f));
        if (pair.frame == frame) {
          canvas.draw().AddLine(at, canvas.ToScreen(pair.pixel.cast<float>()), kSeen, 1);
        }
      }
      if (pair.frame != frame) continue;
      const ImVec2 at = cross(pair.pixel, kPicked);
      labels.Add({{at.x + size, at.y - size}}, colors::kOnPicture, fmt::format("{}", number));
    }
    if (context.annotate->pick_pixel) cross(*context.annotate->pick_pixel, colors::kAccent);
    const char* hint = context.annotate->pick_in_scan ? "Now click the same point here."
                       : context.annotate->pick_pixel ? "Now click the same point in the scan."
                                                      : "Click a point here or in the scan.";
    labels.Add({{0.5f * (canvas.low().x + canvas.high().x - labels.SizeOf(hint).x),
                 canvas.high().y - context.Scaled(6)}},
               colors::kOnPicture, hint);
  }

  bool typing_ = false;   ///< The number of a frame.
  std::string asked_of_;  ///< The project of which the first frame was asked for.
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateFramePanel() { return std::make_unique<AnnotateFramePanel>(); }

}  // namespace plumbline
