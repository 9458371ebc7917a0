// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_agreement.h"

#include <cmath>
#include <string>

#include <fmt/format.h>

#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

std::string DifferenceText(const AgreedRowView& row) {
  if (row.second.empty()) return "only here";
  if (row.first.empty()) return "only there";
  if (row.copied) return "copied, not counted";
  const std::string azimuth =
      row.azimuth_rad ? fmt::format("{:.1f}\u00b0", std::abs(*row.azimuth_rad) * kDegreesPerRadian)
                      : "-";
  return fmt::format("{:.1f}   {:+.1f} cm   {}", 100 * row.horizontal_m, 100 * row.height_m,
                     azimuth);
}

std::string RowHelp(const AgreedRowView& row) {
  if (row.first.empty()) return "Only the other one has it: a click shows where.";
  if (row.second.empty()) return "The other one did not place it: a click shows yours.";
  std::string help = fmt::format(
      "Yours less the other's: {:.1f} cm along the floor, {:+.1f} cm in height, tilt {:.1f}\u00b0. "
      "There it is called {}. A click shows both.",
      100 * row.horizontal_m, 100 * row.height_m, row.tilt_rad * kDegreesPerRadian, row.second);
  if (!row.same_model) help += " There it is the model " + row.second_model + ".";
  return help;
}

void DrawRow(const FrameContext& context, int index, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  const AgreedRowView& row = context.annotation->agreement->rows[static_cast<std::size_t>(index)];
  const std::string name = fmt::format("agreement.{}", index);
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  if (ImGui::Selectable(("##" + name).c_str(), view.agreed_row == index)) {
    view.agreed_row = index;
    if (context.annotation->Find(row.first) != nullptr) {
      sink.Post(SelectInstanceCommand{row.first});
      view.focus_on = row.first;
    }
  }
  LogItem(context, name);
  Tooltip(context, RowHelp(row));
  const std::string difference = DifferenceText(row);
  ImFont& font = *context.fonts.small;
  const float room = font.CalcTextSizeA(font.FontSize, 1e6f, 0, difference.c_str()).x;
  ImGui::SameLine(context.Scaled(2));
  ImGui::PushClipRect(low, {low.x + width - room - context.Scaled(8), low.y + 1e4f}, true);
  SmallText(context, colors::kText, "%s", (row.first.empty() ? row.second : row.first).c_str());
  ImGui::PopClipRect();
  ImGui::SameLine(width - room);
  const bool one_has_it = row.first.empty() || row.second.empty() || !row.same_model;
  SmallText(context, one_has_it ? colors::kWarning : colors::kDimText, "%s", difference.c_str());
}

}  // namespace

void DrawAgreement(const FrameContext& context, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  const AgreementView& agreement = *context.annotation->agreement;
  SmallText(context, colors::kAccent, "Compared with");
  SmallText(context, colors::kText, "%s", agreement.name.c_str());
  if (Button(context, "agreement.close", "Close", "Back to what is placed.")) {
    sink.Post(CompareWithCommand{});
    view.agreed_row = -1;
  }
  if (!agreement.problem.empty()) return WrappedText(colors::kBad, agreement.problem);
  if (agreement.running) return DimText("reading ...");
  if (agreement.pooled > 0) {
    SmallText(context, colors::kDimText, "One annotator: %.1f cm, %.1f\u00b0 (%d objects)",
              100 * agreement.position_std_m, agreement.azimuth_std_rad * kDegreesPerRadian,
              agreement.pooled);
  }
  SmallText(context, colors::kFaint, "along the floor, height, azimuth");
  ImGui::BeginChild("agreement", {0, 0});
  for (int i = 0; i < static_cast<int>(agreement.rows.size()); ++i) DrawRow(context, i, sink);
  ImGui::EndChild();
}

PathQuestion AgreementQuestion(AnnotateView& view) {
  return {.title = "Compare with another annotator's project or ground truth",
          .button = "Compare",
          .kinds = {PathKind::kProject},
          .at = view.second,
          .answer = [&view](const std::string& path, CommandSink& sink) {
            CompareWith(path, view, sink);
          }};
}

void CompareWith(const std::string& path, AnnotateView& view, CommandSink& sink) {
  view.second = path;
  view.check = false;
  view.agreed_row = -1;
  sink.Post(CompareWithCommand{path});
}

}  // namespace plumbline
