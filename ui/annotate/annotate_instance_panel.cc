// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ui/annotate/annotate_edits.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/annotate/number_field.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kShown = 5e-5;
constexpr double kBesideNumber = 86;  ///< Its unit, and a button.

/// In the row of the item before if there is room, else below it.
void NextInRow(const FrameContext& context, const char* label) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float width = ImGui::CalcTextSize(label).x + 2 * style.FramePadding.x;
  const float end = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  const float gap = context.Scaled(6);
  if (ImGui::GetItemRectMax().x + gap + width <= end) ImGui::SameLine(0, gap);
}

class AnnotateInstancePanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    const AnnotatedInstance* instance = context.annotation->Selected();
    if (instance == nullptr) {
      return EmptyState(context, "Nothing is selected",
                        "Click an object in the scan or in the list.");
    }
    ImGui::BeginChild("instance", {0, 0});
    DrawName(context, *instance, sink);
    ImGui::BeginDisabled(instance->locked || context.annotation->read_only);
    DrawPose(context, *instance, sink);
    ImGui::Dummy({0, context.Scaled(2)});
    DrawActions(context, *instance, sink);
    ImGui::EndDisabled();
    DrawQuality(context, *instance, sink);
    DrawNote(context, *instance, sink);
    ImGui::EndChild();
  }

 private:
  void DrawName(const FrameContext& context, const AnnotatedInstance& instance, CommandSink& sink) {
    // Undo, a refusal and other commands change them, too.
    if (shown_id_ != instance.id || shown_note_ != instance.note) {
      shown_id_ = instance.id;
      shown_note_ = instance.note;
      std::snprintf(name_, sizeof(name_), "%s", instance.id.c_str());
      std::snprintf(note_, sizeof(note_), "%s", instance.note.c_str());
    }
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
    ImGui::InputText("##instance.name", name_, sizeof(name_), ImGuiInputTextFlags_AutoSelectAll);
    LogItem(context, "instance.name");
    Tooltip(context, "Its name, unique in the project.");
    if (ImGui::IsItemDeactivatedAfterEdit() && instance.id != name_) {
      ChangeInstanceCommand change;
      change.id = instance.id;
      change.set.id = name_;
      sink.Post(change);
      shown_id_.clear();
    }
    const char* category = instance.category.empty() ? "" : instance.category.c_str();
    SmallText(context, colors::kDimText, "%s \u00b7 %s", instance.model.c_str(), category);
    if (context.annotation->ModelOf(instance) == nullptr) {
      SmallText(context, colors::kBad, "The database has no model of this name.");
    }
  }

  void DrawPose(const FrameContext& context, const AnnotatedInstance& instance, CommandSink& sink) {
    const AnnotationSnapshot& snapshot = *context.annotation;
    const auto& pending = context.annotate->pending;
    const Eigen::Isometry3d& pose = pending && pending->id == instance.id
                                        ? pending->scan_from_object
                                        : instance.scan_from_object;
    const LevelPose level = ReadPose(snapshot, pose);
    const float unit = context.Scaled(76);
    const auto number = [&](const char* name, const char* label, const char* suffix, double value,
                            const char* format, const char* help) -> std::optional<double> {
      ImGui::AlignTextToFramePadding();
      DimText("%s", label);
      ImGui::SameLine(unit);
      ImGui::SetNextItemWidth(std::min(
          context.Scaled(104), ImGui::GetContentRegionAvail().x - context.Scaled(kBesideNumber)));
      const double shown = std::abs(value) < kShown ? 0 : value;  // no "-0.0000"
      const auto typed = numbers_.Draw(context, name, shown, format, help);
      ImGui::SameLine(0, context.Scaled(6));
      DimText("%s", suffix);
      return typed;
    };
    const auto post = [&](const Eigen::Isometry3d& changed) {
      // Shown until the project has it: the next number that is typed goes on from there.
      context.annotate->pending = PendingPose{instance.id, changed, std::nullopt};
      sink.Post(SetInstancePoseCommand{instance.id, changed});
    };
    if (const auto x = number("instance.x", "x", "m", level.x, "%.4f", "In the level frame."))
      post(Moved(snapshot, pose, {*x - level.x, 0, 0}));
    if (const auto y = number("instance.y", "y", "m", level.y, "%.4f", "In the level frame."))
      post(Moved(snapshot, pose, {0, *y - level.y, 0}));
    if (const auto z = number("instance.z", "Height", "m", level.z, "%.4f",
                              "Of the object's foot above the floor."))
      post(Moved(snapshot, pose, {0, 0, *z - level.z}));
    ImGui::SameLine();
    if (Button(context, "instance.floor", "Floor", "Puts it on the floor (G)."))
      post(Moved(snapshot, pose, {0, 0, -level.z}));
    const double degrees = level.azimuth_rad * kDegreesPerRadian;
    if (const auto azimuth = number("instance.azimuth", "Azimuth", "\u00b0", degrees, "%.2f",
                                    "About up: where its front (+x) points."))
      post(Turned(snapshot, pose, {0, 0, 1}, (*azimuth - degrees) / kDegreesPerRadian));
    DrawTilt(context, instance, level.tilt_rad, sink);
    DrawScale(context, instance, sink);
  }

  void DrawScale(const FrameContext& context, const AnnotatedInstance& instance,
                 CommandSink& sink) {
    ImGui::AlignTextToFramePadding();
    DimText("Scale");
    ImGui::SameLine(context.Scaled(76));
    ChangeInstanceCommand change;
    change.id = instance.id;
    if (instance.may_scale) {
      ImGui::SetNextItemWidth(context.Scaled(66));
      const auto typed = numbers_.Draw(context, "instance.scale", instance.scale, "%.4f",
                                       "Times as large as its model, about its foot; 0.1 to 10.");
      if (typed) {
        change.set.scale = *typed;
        sink.Post(change);
      }
    } else {
      ImGui::AlignTextToFramePadding();
      ImGui::Text("%.4f", instance.scale);
    }
    ImGui::SameLine(context.Scaled(146));
    bool may_scale = instance.may_scale;
    if (Toggle(context, "instance.may_scale", may_scale ? "unlocked" : "locked", may_scale,
               "Unlocked, for this object alone, Refine finds from the scan how large it is, too, "
               "where a few per cent are usual; and it can be typed.")) {
      change.set.scale.reset();
      change.set.may_scale = may_scale;
      sink.Post(change);
    }
    if (instance.scale == 1) return;
    ImGui::SameLine();
    if (Button(context, "instance.model_size", "As its model", "Removes the scale.")) {
      change.set = {};
      change.set.scale = 1.0;
      sink.Post(change);
    }
  }

  static void DrawTilt(const FrameContext& context, const AnnotatedInstance& instance,
                       double tilt_rad, CommandSink& sink) {
    ImGui::AlignTextToFramePadding();
    DimText("Tilt");
    ImGui::SameLine(context.Scaled(76));
    ImGui::AlignTextToFramePadding();
    ImGui::Text("%.2f\u00b0", tilt_rad * kDegreesPerRadian);
    ImGui::SameLine(context.Scaled(146));
    bool may_tilt = instance.may_tilt;
    if (Toggle(context, "instance.tilt", may_tilt ? "unlocked" : "locked", may_tilt,
               "Upright is what keeps poses true. Unlocked, for this object alone, two more rings "
               "tilt it, Refine may tilt it, and Check does not call it tilted.")) {
      ChangeInstanceCommand change;
      change.id = instance.id;
      change.set.may_tilt = may_tilt;
      sink.Post(change);
    }
    if (tilt_rad < 1e-5) return;
    ImGui::SameLine();
    if (Button(context, "instance.upright", "Upright", "Removes the tilt.")) {
      sink.Post(SetInstancePoseCommand{instance.id,
                                       Upright(*context.annotation, instance.scan_from_object)});
    }
  }

  static void DrawActions(const FrameContext& context, const AnnotatedInstance& instance,
                          CommandSink& sink) {
    AnnotateView& view = *context.annotate;
    ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
    const bool images = context.annotation->has_sequence;
    if (Button(context, "instance.refine", "Refine",
               images
                   ? "Aligns it from where it is, to the scan and to the edges of its key frames "
                     "together, each as far as it can be trusted (I)."
                   : "Aligns it to the scan from where it is (I).")) {
      sink.Post(RefineInstanceCommand{instance.id, view.on_floor});
    }
    ImGui::PopStyleColor();
    if (images) {
      NextInRow(context, "By scan");
      if (Button(context, "instance.by_scan", "By scan", "Aligns it to the scan alone.")) {
        sink.Post(RefineInstanceCommand{instance.id, view.on_floor, RefineBy::kScan});
      }
      NextInRow(context, "By images");
      if (Button(context, "instance.by_images", "By images",
                 "Aligns its outline to the edges of its key frames alone (Shift + I).")) {
        sink.Post(RefineInstanceCommand{instance.id, view.on_floor, RefineBy::kImages});
      }
    }
    NextInRow(context, "Try azimuths");
    if (Button(context, "instance.again", "Try azimuths",
               "Try all orientations again and choose (T).")) {
      PlaceAgain(context, sink);
    }
    NextInRow(context, "On floor xxxx");  // with its box
    ImGui::Checkbox("On floor", &view.on_floor);
    LogItem(context, "instance.on_floor");
    Tooltip(
        context,
        "What stands on the floor, by its model, is placed standing: on the floor exactly, once "
        "that is known, else on what the scan shows below it. While it is refined it keeps its "
        "height.");
    if (Button(context, "instance.duplicate", "Duplicate",
               "A copy beside it, on a free side (Ctrl + D)."))
      Duplicate(context, sink);
    NextInRow(context, "Copy");
    if (Button(context, "instance.copy", "Copy", "The object and its pose (Ctrl + C).")) {
      CopyInstance(context, instance);
    }
    NextInRow(context, "Paste pose");
    ImGui::BeginDisabled(!view.copied);
    if (Button(context, "instance.paste", "Paste pose",
               "This object takes the copied pose (Ctrl + Shift + V). Ctrl + V puts a copy beside "
               "the copied object."))
      sink.Post(SetInstancePoseCommand{instance.id, *view.copied});
    ImGui::EndDisabled();
    NextInRow(context, "Delete");
    if (Button(context, "instance.delete", "Delete", "Del; Undo restores it."))
      sink.Post(RemoveInstanceCommand{instance.id});
  }

  static void DrawQuality(const FrameContext& context, const AnnotatedInstance& instance,
                          CommandSink& sink) {
    ImGui::Dummy({0, context.Scaled(2)});
    ImGui::AlignTextToFramePadding();
    DimText("Quality");
    ImGui::SameLine(context.Scaled(76));
    for (const bool fine : {true, false}) {
      bool on = instance.fine == fine;
      if (Toggle(context, fine ? "instance.fine" : "instance.coarse", fine ? "fine" : "coarse", on,
                 fine ? "The scan shows it well: counts in mean errors."
                      : "Roughly right: counts apart.") &&
          on) {
        ChangeInstanceCommand change;
        change.id = instance.id;
        change.set.fine = fine;
        sink.Post(change);
      }
      ImGui::SameLine(0, context.Scaled(3));
    }
    ImGui::NewLine();
    const int seconds = static_cast<int>(instance.seconds_spent);
    SmallText(context, colors::kDimText, "%s%s%d min %02d s spent",
              instance.annotator.empty() ? "" : instance.annotator.c_str(),
              instance.annotator.empty() ? "" : ", ", seconds / 60, seconds % 60);
  }

  void DrawNote(const FrameContext& context, const AnnotatedInstance& instance, CommandSink& sink) {
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
    ImGui::InputTextWithHint("##instance.note", "Note", note_, sizeof(note_));
    LogItem(context, "instance.note");
    Tooltip(context, "A note about this object for others.");
    if (!ImGui::IsItemDeactivatedAfterEdit() || instance.note == note_) return;
    ChangeInstanceCommand change;
    change.id = instance.id;
    change.set.note = note_;
    sink.Post(change);
  }

  NumberFields numbers_;
  std::string shown_id_, shown_note_;  ///< That were put into the fields.
  char name_[256] = "", note_[4096] = "";
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateInstancePanel() {
  return std::make_unique<AnnotateInstancePanel>();
}

}  // namespace plumbline
