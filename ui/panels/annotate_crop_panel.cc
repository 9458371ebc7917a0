// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>

#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"
#include "ui/panels/annotate_actions.h"
#include "ui/panels/annotate_panels.h"

namespace plumbline {
namespace {

class AnnotateCropPanel : public Panel {
 public:
  const char* Id() const override { return "annotate_crop"; }
  const char* Title() const override { return "Cut out"; }
  const char* Help() const override {
    return "An object is cut out of the scan: it becomes a model of the database that stands where "
           "it was, or a fragment of a VISMA folder. The scan itself does not change.";
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    AnnotateView& view = *context.annotate;
    ImGui::BeginChild("crop", {0, 0});
    WrappedText(colors::kDimText,
                "Turn the scan so that nothing stands before or behind the object, then drag a box "
                "around it, or click the corners of a line around it and press Enter.");
    ImGui::Dummy({0, context.Scaled(4)});
    Field(context, "crop.name", "Name", view.crop_id,
          "Of the model, or of the fragment: <model>_<N>. Letters, digits, - _ and dots.");
    Field(context, "crop.category", "Category", view.crop_category,
          "What it is, by its COCO name: chair, couch, cup.");
    ImGui::AlignTextToFramePadding();
    DimText("Into");
    ImGui::SameLine(context.Scaled(76));
    for (const bool fragment : {false, true}) {
      bool on = view.crop_fragment == fragment;
      if (Toggle(context, fragment ? "crop.fragment" : "crop.model",
                 fragment ? "VISMA fragment" : "model", on,
                 fragment ? "Its points, written by the export of a VISMA folder."
                          : "A new shape of the database, and an object of it where it stands.")) {
        view.crop_fragment = fragment;
      }
      ImGui::SameLine(0, context.Scaled(3));
    }
    ImGui::NewLine();
    ImGui::Dummy({0, context.Scaled(6)});
    if (context.annotation->crop) DrawProposal(context, *context.annotation->crop, sink);
    ImGui::EndChild();
  }

 private:
  static void Field(const FrameContext& context, const char* name, const char* label,
                    std::string& text, const char* help) {
    char typed[96];
    std::snprintf(typed, sizeof(typed), "%s", text.c_str());
    ImGui::AlignTextToFramePadding();
    DimText("%s", label);
    ImGui::SameLine(context.Scaled(76));
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
    ImGui::InputText((std::string("##") + name).c_str(), typed, sizeof(typed));
    LogItem(context, name);
    Tooltip(context, help);
    text = typed;
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
    ImGui::BeginDisabled(!good);
    ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
    if (Button(context, "proposal.accept", "Take it", "Enter takes it, too, as one edit.")) {
      sink.Post(AcceptProposalCommand{});
      context.annotate->tool = AnnotateTool::kSelect;
    }
    ImGui::PopStyleColor();
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (Button(context, "crop.again", "Again", "The same line, with the name as it is now.")) {
      ProposeCrop(context, sink);
    }
    ImGui::SameLine();
    if (Button(context, "proposal.cancel", "Back", "Forgets the line (Esc).")) {
      context.annotate->lasso.clear();
      sink.Post(CancelProposalCommand{});
    }
  }
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateCropPanel() { return std::make_unique<AnnotateCropPanel>(); }

}  // namespace plumbline
