// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/geometry/gravity.h"
#include "ui/annotate/annotate_edits.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/annotate/number_field.h"
#include "ui/annotate/proposal_buttons.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kLabelWidth = 76;
constexpr double kRowWidth = 275;  ///< Of a label and three numbers; else they go below it.
constexpr double kLeastSide_m = 0.04, kSpare_m = 0.01;

class AnnotateCropPanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    AnnotateView& view = *context.annotate;
    ImGui::BeginChild("crop", {0, 0});
    Choice(
        context, "By", view.crop_by_line,
        {"crop.box", "box", "An upright box with handles, for an object that stands among others."},
        {"crop.line", "line", "A line drawn in the view, through the whole depth of the scan."},
        [&] { DropCut(context, sink); });
    WrappedText(colors::kDimText, Advice(view));
    if (view.crop_box) DrawBox(context, *view.crop_box);
    ImGui::Dummy({0, context.Scaled(4)});
    Field(context, "crop.name", "Name", view.crop_id,
          "Of the model, or of the fragment: <model>_<N>. Letters, digits, - _ and dots.");
    Field(context, "crop.category", "Category", view.crop_category,
          "Its category by COCO name: chair, couch, cup.");
    Choice(
        context, "Into", view.crop_fragment,
        {"crop.model", "model",
         "A new model in the database, and an instance of it where it stands."},
        {"crop.fragment", "VISMA fragment", "Its points, written by the export of a VISMA folder."},
        [] {});
    ImGui::Dummy({0, context.Scaled(6)});
    if (context.annotation->crop) {
      DrawProposal(context, *context.annotation->crop, sink);
    } else if (view.crop_box || view.lasso.size() > 2) {
      ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
      if (Button(context, "crop.cut", "Cut", "Shows what would be cut out (Enter).")) {
        ProposeCrop(context, sink);
      }
      ImGui::PopStyleColor();
      ImGui::SameLine();
      if (Button(context, "crop.drop", "Discard", "Forgets the box or the line (Esc).")) {
        DropCut(context, sink);
      }
    }
    ImGui::EndChild();
  }

 private:
  struct Option {
    const char* name;
    const char* label;
    const char* help;
  };

  static std::string Advice(const AnnotateView& view) {
    if (view.crop_by_line) {
      return "Turn the scan so that nothing stands before or behind the object, then drag a box "
             "around it, or click the corners of a line around it and press Enter.";
    }
    if (!view.crop_box) return "Click the object in the scan: a box is fitted around it.";
    return "Drag the discs to move the sides, the square to move the box, the ring to turn it; the "
           "keys W A S D, Q E, Z X, too.";
  }

  /// Before what is wide: beside it or, in a narrow panel, above it.
  static void Label(const FrameContext& context, const char* label) {
    const bool beside = ImGui::GetContentRegionAvail().x >= context.Scaled(kRowWidth);
    if (beside) ImGui::AlignTextToFramePadding();
    DimText("%s", label);
    if (beside) ImGui::SameLine(context.Scaled(kLabelWidth));
  }

  /// One of two, in a row after its label; `changed` is called when it is the other one.
  template <typename Changed>
  static void Choice(const FrameContext& context, const char* label, bool& second,
                     const Option& first, const Option& other, Changed changed) {
    Label(context, label);
    for (const bool which : {false, true}) {
      const Option& option = which ? other : first;
      bool on = second == which;
      if (Toggle(context, option.name, option.label, on, option.help) && second != which) {
        second = which;
        changed();
      }
      ImGui::SameLine(0, context.Scaled(3));
    }
    ImGui::NewLine();
  }

  static void Field(const FrameContext& context, const char* name, const char* label,
                    std::string& text, const char* help) {
    char typed[96];
    std::snprintf(typed, sizeof(typed), "%s", text.c_str());
    ImGui::AlignTextToFramePadding();
    DimText("%s", label);
    ImGui::SameLine(context.Scaled(kLabelWidth));
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
    ImGui::InputText((std::string("##") + name).c_str(), typed, sizeof(typed));
    LogItem(context, name);
    Tooltip(context, help);
    text = typed;
  }

  /// Numbers of the box that can be typed.
  void DrawBox(const FrameContext& context, LevelBox& box) {
    const float width = context.Scaled(56);
    const auto number = [&](const char* name, double value, const char* format,
                            const char* help) -> std::optional<double> {
      ImGui::SetNextItemWidth(width);
      const auto typed = numbers_.Draw(context, name, value, format, help);
      ImGui::SameLine(0, context.Scaled(4));
      return typed;
    };
    const auto unit = [](const char* text) {
      ImGui::AlignTextToFramePadding();
      DimText("%s", text);
    };
    Label(context, "Size");
    constexpr const char* kSides[] = {"crop.size_x", "crop.size_y", "crop.size_z"};
    for (int axis = 0; axis < 3; ++axis) {
      const auto size = number(kSides[axis], box.size_m[axis], "%.3f",
                               "Along its front, across it, and its height.");
      if (size) Resize(box, axis, std::max(kLeastSide_m, *size));
    }
    unit("m");
    Label(context, "Middle");
    if (const auto x = number("crop.x", box.center.x(), "%.3f", "In the level frame."))
      box.center.x() = *x;
    if (const auto y = number("crop.y", box.center.y(), "%.3f", "In the level frame."))
      box.center.y() = *y;
    if (const auto z = number("crop.bottom", box.center.z() - 0.5 * box.size_m.z(), "%.3f",
                              "Height of the bottom above the floor."))
      box.center.z() = *z + 0.5 * box.size_m.z();
    unit("m");
    Label(context, "Azimuth");
    if (const auto azimuth = number("crop.azimuth", box.azimuth_rad * kDegreesPerRadian, "%.1f",
                                    "About up: where its front points."))
      box.azimuth_rad = WrapAngle(*azimuth / kDegreesPerRadian);
    unit("\u00b0");
    const auto& inside = context.annotation->box;
    Label(context, "Inside");
    unit(fmt::format("{} points", inside ? inside->points->size() : 0).c_str());
    ImGui::SameLine();
    ImGui::BeginDisabled(!inside || inside->bounds.isEmpty());
    if (Button(context, "crop.shrink", "Shrink",
               "The sides come in to the points that are inside; those on the floor do not "
               "count.")) {
      Shrink(inside->bounds, box);
    }
    ImGui::EndDisabled();
  }

  /// The bottom stays where the height changes.
  static void Resize(LevelBox& box, int axis, double size_m) {
    if (axis == 2) box.center.z() += 0.5 * (size_m - box.size_m.z());
    box.size_m[axis] = size_m;
  }

  static void Shrink(const Eigen::AlignedBox3d& bounds, LevelBox& box) {
    const Eigen::AngleAxisd turn(box.azimuth_rad, Eigen::Vector3d::UnitZ());
    box.center += turn * bounds.center();
    box.size_m = (bounds.sizes().array() + 2 * kSpare_m).max(kLeastSide_m).min(box.size_m.array());
  }

  static void DrawProposal(const FrameContext& context, const CropView& crop, CommandSink& sink) {
    const bool good = !crop.running && crop.problem.empty();
    if (crop.running) DimText("cutting it out ...");
    if (!crop.problem.empty()) WrappedText(colors::kWarning, crop.problem);
    if (good) {
      ImGui::TextUnformatted(crop.id.c_str());
      DimText("%.2f x %.2f x %.2f m", crop.size_m.x(), crop.size_m.y(), crop.size_m.z());
      DimText("%zu points", crop.points == nullptr ? 0 : crop.points->size());
      if (crop.num_faces > 0) DimText("%d faces", crop.num_faces);
      if (crop.support_height_m) {
        DimText("cut off what it stands on, at %.1f cm", 100 * *crop.support_height_m);
      }
    }
    ImGui::Dummy({0, context.Scaled(6)});
    const ProposalAnswer answer =
        DrawProposalButtons(context, "Accept", "Enter accepts it too, as one edit.", good,
                            "Forgets the box or the line (Esc).");
    if (answer == ProposalAnswer::kAccept) {
      sink.Post(AcceptProposalCommand{});
      context.annotate->tool = AnnotateTool::kSelect;
    }
    if (answer == ProposalAnswer::kDiscard) DropCut(context, sink);
    ImGui::SameLine();
    if (Button(context, "crop.again", "Again", "The same cut, with the name as it is now.")) {
      ProposeCrop(context, sink);
    }
  }

  NumberFields numbers_;
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateCropPanel() { return std::make_unique<AnnotateCropPanel>(); }

}  // namespace plumbline
