// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>

#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/annotate/proposal_buttons.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/path_dialog.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

using How = AlignSequenceCommand::How;

class AnnotateSequencePanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    ImGui::BeginChild("sequence", {0, 0});
    if (context.annotation->sequence_alignment) {
      DrawProposal(context, *context.annotation->sequence_alignment, sink);
    } else {
      DrawWays(context, sink);
    }
    ImGui::EndChild();
  }

 private:
  static void DrawWays(const FrameContext& context, CommandSink& sink) {
    AnnotateView& view = *context.annotate;
    const AnnotationSnapshot& snapshot = *context.annotation;
    WrappedText(colors::kDimText,
                snapshot.sequence_registered
                    ? "The sequence is registered to the scan. Do it again:"
                    : "The sequence counts as being in the scan's frame. If it is "
                      "not, register it:");
    ImGui::Dummy({0, context.Scaled(6)});
    SmallText(context, colors::kAccent, "By pairs");
    WrappedText(
        colors::kDimText,
        "Click a point in the scan and the same point in a frame, three or more, far apart.");
    DrawPairs(context, sink);
    ImGui::BeginDisabled(snapshot.pairs.size() < 2);
    if (Button(context, "sequence.by_pairs", "Register by pairs",
               "Proposes it; nothing changes yet.")) {
      sink.Post(AlignSequenceCommand{How::kPairs, ""});
    }
    ImGui::EndDisabled();
    ImGui::Dummy({0, context.Scaled(8)});
    SmallText(context, colors::kAccent, "By the points of its map");
    File(context, How::kPoints, "sequence.points", "MAP.ply", view.map_points,
         "Sparse points of the sequence's map, in its own frame: laid onto the scan (ICP), from "
         "where it is now or, if it is not registered, from all sides.",
         sink);
    ImGui::Dummy({0, context.Scaled(8)});
    SmallText(context, colors::kAccent, "By mapped objects");
    File(context, How::kObjects, "sequence.objects", "RUN.plb", view.mapped_run,
         "A run of this sequence: its objects are brought onto the annotated ones of their kind.",
         sink);
  }

  static void DrawPairs(const FrameContext& context, CommandSink& sink) {
    const auto& pairs = context.annotation->pairs;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      ImGui::AlignTextToFramePadding();
      ImGui::Text("%zu", i + 1);
      ImGui::SameLine(context.Scaled(26));
      DimText("frame %d", pairs[i].frame);
      ImGui::SameLine(context.Scaled(120));
      if (pairs[i].seen_at) {
        ImGui::Text("%.1f px", pairs[i].residual_px);
      } else {
        DimText("not seen");
      }
      ImGui::SameLine(context.Scaled(200));
      const std::string name = fmt::format("sequence.remove.{}", i);
      ImGui::PushID(static_cast<int>(i));
      if (Button(context, name, "Remove", "Forgets this pair.")) sink.Post(RemovePairCommand{i});
      ImGui::PopID();
    }
    ImGui::Dummy({0, context.Scaled(2)});
  }

  static void File(const FrameContext& context, How how, const std::string& name, const char* hint,
                   std::string& path, const char* help, CommandSink& sink) {
    char text[512];
    std::snprintf(text, sizeof(text), "%s", path.c_str());
    const float button = context.Scaled(78);
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - button - context.Scaled(6) -
                            BrowseWidth(context));
    const bool entered = ImGui::InputTextWithHint(("##" + name).c_str(), hint, text, sizeof(text),
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    LogItem(context, name + ".field");
    Tooltip(context, help);
    path = text;
    BrowseButton(context, name + ".browse", [&] {
      return PathQuestion{.title = how == How::kObjects
                                       ? "Register by the objects of a run"
                                       : "Register by the points of the sequence's map",
                          .button = "Register",
                          .kinds = {how == How::kObjects ? PathKind::kRun : PathKind::kScan},
                          .at = path,
                          .answer = [&path, how](const std::string& chosen, CommandSink& to) {
                            path = chosen;
                            to.Post(AlignSequenceCommand{how, chosen});
                          }};
    });
    ImGui::SameLine(0, context.Scaled(6));
    ImGui::PushID(name.c_str());
    const bool clicked = Button(context, name, "Register", help);
    ImGui::PopID();
    if ((entered || clicked) && !path.empty()) sink.Post(AlignSequenceCommand{how, path});
  }

  static void DrawProposal(const FrameContext& context, const SequenceAlignmentView& proposal,
                           CommandSink& sink) {
    ImGui::Text("By %s", proposal.how.c_str());
    if (proposal.running) DimText("looking for it ...");
    if (!proposal.problem.empty()) WrappedText(colors::kWarning, proposal.problem);
    const bool good = !proposal.running && proposal.problem.empty();
    ImGui::Dummy({0, context.Scaled(2)});
    if (good) DrawNumbers(context, proposal);
    if (good) DrawResiduals(context, proposal);
    ImGui::Dummy({0, context.Scaled(6)});
    const ProposalAnswer answer =
        DrawProposalButtons(context, "Accept", "Enter accepts it too, as one edit.", good,
                            "Leaves it where it was (Esc).");
    if (answer == ProposalAnswer::kAccept) {
      sink.Post(AcceptProposalCommand{});
      context.annotate->tool = AnnotateTool::kSelect;
    }
    if (answer == ProposalAnswer::kDiscard) sink.Post(CancelProposalCommand{});
  }

  static void DrawNumbers(const FrameContext& context, const SequenceAlignmentView& proposal) {
    if (!ImGui::BeginTable("sequence.table", 3, ImGuiTableFlags_SizingFixedFit)) return;
    TableRow("Turns by", fmt::format("{:.2f}\u00b0", proposal.turn_rad * kDegreesPerRadian),
             fmt::format("\u00b1 {:.2f}\u00b0", proposal.azimuth_std_rad * kDegreesPerRadian));
    TableRow("Cameras move", fmt::format("{:.1f} cm", 100 * proposal.shift_m),
             fmt::format("\u00b1 {:.1f} cm", 100 * proposal.position_std_m.norm()));
    if (proposal.rmse_m > 0) {
      TableRow("Residual", fmt::format("{:.1f} cm rms", 100 * proposal.rmse_m),
               fmt::format("{:.0f} % used", 100 * proposal.share));
    }
    ImGui::EndTable();
    LogItem(context, "sequence.table");
  }

  static void DrawResiduals(const FrameContext& context, const SequenceAlignmentView& proposal) {
    const auto line = [&](const std::string& name, const std::string& value) {
      DimText("%s", name.c_str());
      ImGui::SameLine(context.Scaled(170));
      ImGui::TextUnformatted(value.c_str());
    };
    ImGui::Dummy({0, context.Scaled(4)});
    if (proposal.how == "pairs") {
      int number = 0;
      for (const PairView& pair : context.annotation->pairs) {
        line(fmt::format("{}  frame {}", ++number, pair.frame),
             pair.seen_at ? fmt::format("{:.1f} px", pair.residual_px) : "not seen");
      }
    }
    for (const auto& residual : proposal.residuals) {
      line(residual.name,
           residual.meters < 0 ? "none near" : fmt::format("{:.1f} cm", 100 * residual.meters));
    }
  }
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateSequencePanel() {
  return std::make_unique<AnnotateSequencePanel>();
}

}  // namespace plumbline
