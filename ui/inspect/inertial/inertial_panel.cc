// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/inertial/inertial_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/geometry/angles.h"
#include "engine/snapshot/lens_entries.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/files/kept_value.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/inertial/inertial_plot.h"

namespace plumbline {
namespace {

std::string Axes(const Eigen::Vector3d& v, double per_unit, const char* unit, int digits) {
  return fmt::format("{:+.{}f} {:+.{}f} {:+.{}f} {}", per_unit * v.x(), digits, per_unit * v.y(),
                     digits, per_unit * v.z(), digits, unit);
}

std::string Bound(double std, const char* unit, int digits) {
  return fmt::format("± {:.{}f} {}", std, digits, unit);
}

class InertialPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    AlignRight(ToggleWidth(context, "Over time"));
    Toggle(context, "inertial.over_time", "Over time", over_time_,
           "Rates, biases with their bounds, innovations with their gate and the distance from the "
           "reference, over all frames.");
  }

  void Draw(const FrameContext& context, CommandSink&) override {
    if (DrawWaiting(context)) return;
    const OwnPoses* poses = context.sequence->own_poses.get();
    if (poses == nullptr) {
      return EmptyState(context, "Poses are given",
                        "A run with --poses vio finds its own from images and IMU, and shows the "
                        "filter here.");
    }
    const auto at = static_cast<std::size_t>(context.snapshot->report.frame);
    if (at >= poses->frames.size())
      return EmptyState(context, "Nothing known", "The filter did not look at this frame.");
    const OwnPoseReport& frame = poses->frames[at];
    ImGui::PushFont(context.fonts.small);
    ImGui::BeginChild("inertial.scroll", ImGui::GetContentRegionAvail());
    DrawState(frame);
    DrawLoops(*poses, static_cast<int>(at));
    if (over_time_) {
      plots_.Draw(context);
    } else {
      DrawTables(context, frame);
    }
    ImGui::EndChild();
    ImGui::PopFont();
  }

  nlohmann::json SaveState() const override { return {{"over_time", over_time_}}; }
  void LoadState(const nlohmann::json& json) override {
    over_time_ = KeptValue(json, "over_time", over_time_);
  }

 private:
  static void DrawState(const OwnPoseReport& frame) {
    if (!frame.ready) return WrappedText(colors::kWarning, "Mapping waits: " + frame.waits_for);
    if (!frame.vio.message.empty()) return WrappedText(colors::kWarning, frame.vio.message);
    std::string text = frame.vio.resting ? "Tracking, at rest" : "Tracking";
    if (!frame.measured) text += "; this image came too soon, the pose is the IMU's prediction";
    if (frame.vio.stretch > 1) text += fmt::format("; start {}", frame.vio.stretch);
    WrappedText(colors::kGood, text);
  }

  /// Places known again, and the corrections that this frame's pose contains.
  static void DrawLoops(const OwnPoses& poses, int frame) {
    if (poses.loops.closures.empty()) return;
    std::string text = fmt::format("{} loops closed, correction {} of {}{}", poses.loops.believed(),
                                   poses.EpochAt(frame), poses.loops.epochs,
                                   poses.causal ? "" : ", known before mapping began");
    for (const LoopClosure& closure : poses.loops.closures) {
      if (closure.image != frame) continue;
      text += fmt::format("; here: frame {} seen again by {} points{}", closure.old_image,
                          closure.inliers, closure.trust < 0.5 ? ", given up" : "");
    }
    WrappedText(colors::kAccent, text);
  }

  /// Side by side where there is room.
  static void DrawTables(const FrameContext& context, const OwnPoseReport& frame) {
    constexpr ImGuiTableFlags kFlags =
        ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_NoHostExtendX;
    const bool wide = ImGui::GetContentRegionAvail().x > context.Scaled(640);
    if (ImGui::BeginTable("inertial.motion", 3, kFlags)) {
      DrawMotion(context, frame);
      ImGui::EndTable();
    }
    if (wide) ImGui::SameLine(0, context.Scaled(28));
    if (ImGui::BeginTable("inertial.filter", 3, kFlags)) {
      if (frame.world_from_cam) DrawCalibration(frame);
      ImGui::EndTable();
    }
  }

  static void DrawMotion(const FrameContext& context, const OwnPoseReport& frame) {
    const VioReport& vio = frame.vio;
    TableRow("turning", Axes(frame.angular_velocity_rad_s, kDegPerRad, "deg/s", 1), "gyro");
    TableRow("specific force", Axes(frame.specific_force_m_s2, 1, "m/s²", 2), "accelerometer");
    DrawTracks(frame);
    if (!frame.world_from_cam) return;
    TableRow("velocity", fmt::format("{:.3f} m/s", vio.velocity_in_world.norm()),
             Bound(frame.velocity_std_m_s, "m/s", 3));
    TableRow("gravity", "", Bound(frame.tilt_std_rad * kDegPerRad, "deg", 2));
    const double position_m =
        std::sqrt(std::max(0.0, frame.cam_covariance.diagonal().head<3>().maxCoeff()));
    TableRow("position", "", Bound(100 * position_m, "cm", 1));
    if (const auto distance =
            DistanceFromReference(*context.sequence, context.snapshot->report.frame))
      TableRow("off the reference", fmt::format("{:.1f} cm", 100 * *distance), "aligned");
  }

  static void DrawCalibration(const OwnPoseReport& frame) {
    const VioReport& vio = frame.vio;
    const auto& spread = vio.spread;
    TableRow("gyro bias", Axes(vio.gyro_bias, kDegPerRad, "deg/s", 3),
             Bound(spread.segment<3>(0).maxCoeff() * kDegPerRad, "", 3));
    TableRow("accelerometer bias", Axes(vio.accel_bias, 1, "m/s²", 3),
             Bound(spread.segment<3>(3).maxCoeff(), "", 3));
    const Eigen::AngleAxisd turn(vio.body_from_cam.linear());
    TableRow("camera on body", Axes(turn.angle() * turn.axis(), kDegPerRad, "deg", 2),
             Bound(spread.segment<3>(6).maxCoeff() * kDegPerRad, "", 2));
    TableRow("", Axes(vio.body_from_cam.translation(), 1000, "mm", 1),
             Bound(1000 * spread.segment<3>(9).maxCoeff(), "", 1));
    TableRow("clock offset", fmt::format("{:+.2f} ms", 1000 * vio.time_offset_s),
             Bound(1000 * spread[12], "", 2));
    DrawLens(vio);
    if (vio.step.nis_dof > 0) {
      TableRow("innovations", fmt::format("{:.0f} of {}", vio.step.nis, vio.step.nis_dof),
               fmt::format("95 % gate {:.0f}", frame.nis_gate));
    }
    TableRow("measurements", fmt::format("{} used", vio.step.accepted),
             fmt::format("{} rejected", vio.step.rejected));
    if (frame.floor) {
      TableRow(
          "floor", fmt::format("{:+.3f} m", frame.floor->height_m),
          fmt::format("± {:.1f} cm, {} points", 100 * frame.floor->std_m, frame.floor->points));
    } else {
      TableRow("floor", "not found", "");
    }
    TableRow(
        "time",
        fmt::format("{:.1f} ms", frame.tracking_ms + vio.step.propagate_ms + vio.step.update_ms),
        fmt::format("tracking {:.1f} ms", frame.tracking_ms));
  }

  /// What the filter refines of it; nothing where it takes the lens as given.
  static void DrawLens(const VioReport& vio) {
    for (int row = 0; row < kLensSize; ++row) {
      if (vio.lens_spread[row] <= 0) continue;
      const LensEntry entry = kLensEntries[static_cast<std::size_t>(row)];
      TableRow(entry.name,
               fmt::format("{:.{}f} {}", entry.factor * vio.lens[row], entry.digits, entry.unit),
               Bound(entry.factor * vio.lens_spread[row], "", entry.digits));
    }
  }

  static void DrawTracks(const OwnPoseReport& frame) {
    int in_state = 0, rejected = 0, age = 0;
    for (const TrackReport& track : frame.tracks) {
      in_state += track.state == TrackState::kInState;
      rejected += track.state == TrackState::kRejected;
      age += track.age;
    }
    const auto count = static_cast<int>(frame.tracks.size());
    TableRow("tracks", fmt::format("{}, {} in the state", count, in_state + rejected),
             count > 0 ? fmt::format("{} rejected, mean age {}", rejected, age / count) : "");
  }

  bool over_time_ = false;
  InertialPlots plots_;
};

}  // namespace

std::unique_ptr<Panel> MakeInertialPanel() { return std::make_unique<InertialPanel>(); }

}  // namespace plumbline
