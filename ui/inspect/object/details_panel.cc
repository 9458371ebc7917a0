// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/object/details_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/geometry/angle_text.h"
#include "engine/geometry/gravity.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

void Fact(const FrameContext& context, const char* name, const std::string& value,
          const char* help) {
  ImGui::TableNextColumn();
  DimText("%s", name);
  Tooltip(context, help);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(value.c_str());
}

std::string PlaceText(const Eigen::Vector3d& p) {
  return fmt::format("{}  {}  {} m", NumberText(p.x(), 2), NumberText(p.y(), 2),
                     NumberText(p.z(), 2));
}

/// Share of the belief that lies in none of the modes.
double BeliefElsewhere(const ObjectReport& object) {
  double elsewhere = object.modes.empty() ? 0 : 1;
  for (const PoseMode& mode : object.modes) elsewhere -= mode.weight;
  return elsewhere;
}

/// Whether so much lies in none of the modes that it shows in the spread of all hypotheses.
bool HasStragglers(const ObjectReport& object) { return BeliefElsewhere(object) > 0.015; }

class DetailsPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink& sink) override {
    const ObjectReport* object = context.SelectedObject();
    if (object == nullptr) return;
    AlignRight(ToggleWidth(context, "Frame in 3-D"));
    bool ignored = false;
    if (Toggle(context, "details.focus", "Frame in 3-D", ignored,
               "Turns the 3-D view to this object (F).")) {
      sink.Post(FocusSelectionCommand{});
    }
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const ObjectReport* object = context.SelectedObject();
    if (object == nullptr) {
      return context.selection.object.value > 0
                 ? EmptyState(
                       context,
                       fmt::format("Object #{} is not in this frame",
                                   context.selection.object.value)
                           .c_str(),
                       "It was spawned later, or has been retired. Esc clears the selection.")
                 : EmptyState(context, "No object selected",
                              "Click one in the list, in an image or in the 3-D view.");
    }
    ImGui::PushFont(context.fonts.small);
    ImGui::BeginChild("details.scroll", ImGui::GetContentRegionAvail());
    const bool wide = ImGui::GetContentRegionAvail().x > context.Scaled(390);
    if (ImGui::BeginTable("details.columns", wide ? 2 : 1, ImGuiTableFlags_None)) {
      ImGui::TableNextColumn();
      DrawFacts(context, *object);
      ImGui::TableNextColumn();
      DrawLabels(context, *object);
      DrawModes(context, *object, sink);
      ImGui::EndTable();
    }
    ImGui::EndChild();
    ImGui::PopFont();
  }

 private:
  static void DrawFacts(const FrameContext& context, const ObjectReport& object) {
    if (!ImGui::BeginTable("details.facts", 2, ImGuiTableFlags_SizingFixedFit)) return;
    const UprightFrame upright(-context.sequence->up_in_world);
    const Eigen::Vector3d p = object.world_from_object.translation();
    ImGui::TableNextColumn();
    Chip(context, object.id);
    ImGui::Text("#%d", object.id.value);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(object.category.c_str());
    const bool several = object.modes.size() > 1 || HasStragglers(object);
    const ObjectSpread* spread = context.SpreadOf(object.id);
    Fact(context, "position", PlaceText(p),
         "Origin of the model in the world: x, y, z. Of several modes, the heaviest one's.");
    if (several && spread != nullptr)
      Fact(
          context, "spread",
          fmt::format("\u00b1 {:.1f} cm{}", 100 * spread->position_std_m,
                      spread->azimuth_std_rad ? fmt::format(", \u00b1 {:.0f}\u00b0",
                                                            kDegPerRad * *spread->azimuth_std_rad)
                                              : ""),
          "Standard deviation of all hypotheses: of the position (root of the sum over three axes) "
          "and of the azimuth.");
    Fact(context, several ? "of the mode" : "spread",
         fmt::format("\u00b1 {:.1f}  {:.1f}  {:.1f} cm", 100 * std::sqrt(object.covariance(0, 0)),
                     100 * std::sqrt(object.covariance(1, 1)),
                     100 * std::sqrt(object.covariance(2, 2))),
         several ? "Standard deviation of the heaviest mode alone along the world's x, y, z."
                 : "Standard deviation along the world's x, y, z.");
    const ModelView* model = context.Model(object.label);
    if (model != nullptr && model->any_azimuth) {
      Fact(context, "azimuth", "round", "The model looks the same from all sides.");
    } else {
      Fact(context, "azimuth",
           fmt::format("{} \u00b1 {:.1f}\u00b0",
                       AngleText(upright.Azimuth(object.world_from_object.linear())),
                       kDegPerRad * std::sqrt(std::max(0.0, object.covariance(3, 3)))),
           "Angle about the vertical from the world's +x to the object's front.");
    }
    if (object.scale_std > 0) {
      Fact(context, "size",
           fmt::format("{:+.1f} \u00b1 {:.1f} %", 100 * (object.scale - 1), 100 * object.scale_std),
           "How much larger than its model it is, about the middle of its base.");
    }
    Fact(context, "score",
         fmt::format("\u03a6 det {:.2f}   \u03a6 edge {:.2f}", object.phi_cnn, object.phi_edge),
         "Both terms of the score at the mean state, of the detector and of the edges, in the last "
         "frame in which enough of it showed.");
    Fact(context, "evidence", fmt::format("{:+.1f}", object.log_evidence),
         "Log odds that the object exists.");
    Fact(context, "sample size",
         fmt::format("{:.0f} of {}", object.effective_sample_size,
                     object.particles == nullptr ? 0 : object.particles->size()),
         "Effective number of particles: few mean that the weight sits on few hypotheses.");
    Fact(context, "spawned", fmt::format("frame {}", object.first_frame),
         "Frame whose proposal it was spawned from.");
    Fact(context, "confirmed",
         object.confirmed_frame ? fmt::format("frame {}", *object.confirmed_frame) : "not yet",
         "Frame in which the evidence sufficed.");
    Fact(context, "last updated", fmt::format("frame {}", object.last_frame),
         "Last frame in which enough of it showed.");
    DrawSecondPass(context, object);
    ImGui::EndTable();
  }

  /// What smoothing made of the object, where the run has been smoothed.
  static void DrawSecondPass(const FrameContext& context, const ObjectReport& object) {
    if (context.sequence->smoothed == nullptr) return;
    for (const SmoothedObject& smoothed : context.sequence->smoothed->objects) {
      const ObjectReport& belief = smoothed.belief;
      if (belief.id != object.id) continue;
      const double moved_m =
          (belief.world_from_object.translation() - object.world_from_object.translation()).norm();
      const double turned_rad = Eigen::AngleAxisd(belief.world_from_object.linear().transpose() *
                                                  object.world_from_object.linear())
                                    .angle();
      const ModelView* model = context.Model(belief.label);
      const bool round = model != nullptr && model->any_azimuth;
      Fact(
          context, "second pass",
          fmt::format("{}, {:.1f} cm{} from here",
                      belief.state == ObjectState::kConfirmed ? "there" : "not sure", 100 * moved_m,
                      round ? "" : fmt::format(", {:.1f}\u00b0", kDegPerRad * turned_rad)),
          "What all frames together say of it (Smoothed in the map), and how far that is from "
          "the mean state in this frame.");
      Fact(context, "",
           fmt::format("{} looks, refined in {} views", smoothed.looks, smoothed.views),
           "Independent looks at it over the whole run, and views that its pose comes from.");
      return;
    }
    Fact(context, "second pass", "left out", "It is not among the objects of the second pass.");
  }

  static void DrawLabels(const FrameContext& context, const ObjectReport& object) {
    DimText("Which model");
    Tooltip(context,
            "Probability of each shape of the category. Once the object is confirmed, other "
            "shapes are put in its place and compared.");
    const ImVec2 bar(std::max(context.Scaled(40), 0.34f * ImGui::GetContentRegionAvail().x),
                     ImGui::GetTextLineHeight() * 0.55f);
    int shown = 0;
    for (const LabelProbability& label : object.label_probability) {
      if (++shown > 6) break;
      const ModelView* model = context.Model(label.label);
      const float top = ImGui::GetCursorPosY();
      ImGui::SetCursorPosY(top + 0.25f * ImGui::GetTextLineHeight());
      Bar(bar, label.probability, OnPanel(context.ColorOf(object.id)));
      ImGui::SameLine();
      ImGui::SetCursorPosY(top);
      ImGui::Text("%3.0f %%  %s", 100 * label.probability,
                  model != nullptr ? model->name.c_str() : "?");
    }
  }

  static void DrawModes(const FrameContext& context, const ObjectReport& object,
                        CommandSink& sink) {
    ImGui::Dummy({0, context.Scaled(2)});
    std::string places = object.modes.size() > 1
                             ? fmt::format("{} separate places", object.modes.size())
                             : std::string("One place");
    if (HasStragglers(object))
      places += fmt::format(", {:.0f} % elsewhere", 100 * BeliefElsewhere(object));
    DimText("%s", places.c_str());
    if (HasStragglers(object)) LogItem(context, "details.elsewhere");
    Tooltip(
        context,
        "Clearly separate groups of hypotheses, for example a chair and the same chair turned "
        "by 180 degrees. They are never averaged. Single hypotheses elsewhere are no place, but "
        "count in the spread of all.");
    if (object.modes.size() < 2) return;  // all is said beside
    const UprightFrame upright(-context.sequence->up_in_world);
    const float line = ImGui::GetTextLineHeight();
    for (std::size_t i = 0; i < object.modes.size(); ++i) {
      const PoseMode& mode = object.modes[i];
      const std::string name = fmt::format("details.mode.{}", i);
      const ImVec2 at = ImGui::GetCursorScreenPos();
      if (ImGui::Selectable(("##" + name).c_str(), false, 0, {0, 2 * line}))
        sink.Post(FocusModeCommand{static_cast<int>(i)});
      LogItem(context, name);
      Tooltip(context, "A click turns the map to it and marks the hypothesis nearest to it.");
      const ModelView* model = context.Model(mode.label);
      const std::string turned =
          model != nullptr && model->any_azimuth
              ? std::string("any azimuth")
              : fmt::format("azimuth {} \u00b1 {:.1f}\u00b0",
                            AngleText(upright.Azimuth(mode.world_from_object.linear())),
                            kDegPerRad * mode.azimuth_std_rad);
      const std::string shape = mode.label == object.label ? ""
                                : model != nullptr         ? ", " + model->name
                                                           : ", ?";
      ImDrawList& draw = *ImGui::GetWindowDrawList();
      const float indent = ImGui::CalcTextSize("100 %  ").x;
      draw.AddText(at, colors::kText, fmt::format("{:.0f} %", 100 * mode.weight).c_str());
      draw.AddText(
          {at.x + indent, at.y}, colors::kText,
          fmt::format("{} \u00b1 {:.1f} cm", PlaceText(mode.world_from_object.translation()),
                      100 * mode.position_std_m)
              .c_str());
      draw.AddText({at.x + indent, at.y + line}, colors::kDimText, (turned + shape).c_str());
    }
  }
};

}  // namespace

std::unique_ptr<Panel> MakeDetailsPanel() { return std::make_unique<DetailsPanel>(); }

}  // namespace plumbline
