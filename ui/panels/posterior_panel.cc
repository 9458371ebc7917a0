// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/geometry/gravity.h"
#include "engine/snapshot/calibration.h"
#include "ui/framework/widgets.h"
#include "ui/panels/panels.h"
#include "ui/panels/waiting.h"

namespace plumbline {
namespace {

constexpr double kDegrees = 57.29577951308232;
constexpr int kBins = 36;

/// The four parameters of a place, as people read them: bearing to the right and down [deg],
/// log-depth, azimuth [deg].
struct Parameters {
  double value[4];
};

struct Axis {
  const char* name;
  const char* unit;
  const char* help;
  double least_reach;  ///< Narrower beliefs are not blown up further than this.
};
constexpr Axis kAxes[] = {
    {"bearing, right", "\u00b0", "Angle to the right of the reference camera's axis.", 0.1},
    {"bearing, down", "\u00b0", "Angle below the reference camera's axis.", 0.1},
    {"log-depth", "", "Logarithm of the depth before the reference camera [m].", 0.004},
    {"azimuth", "\u00b0",
     "Turn about up. Where a shape looks the same from several sides, the "
     "true azimuth is the one nearest to the mean.",
     0.5}};
constexpr int kDepth = 2, kAzimuth = 3;

Parameters At(const Eigen::Vector3d& center_in_cam, double azimuth_rad) {
  const double z = std::max(0.05, center_in_cam.z());
  return {{kDegrees * std::atan(center_in_cam.x() / z), kDegrees * std::atan(center_in_cam.y() / z),
           std::log(z), kDegrees * azimuth_rad}};
}

/// Weighted histograms of an object's particles.
struct Marginals {
  double low[4], high[4], mean[4], std[4];
  double share[4][kBins] = {};
  std::optional<Parameters> truth;
};

const SequenceView::Truth* TruthOf(const FrameContext& context) {
  for (const auto& frame : context.playback->history->frames) {
    if (frame == nullptr || frame->frame != context.snapshot->report.frame) continue;
    for (const ObjectSample& sample : frame->objects) {
      if (sample.id != context.selection.object || !sample.error) continue;
      for (const SequenceView::Truth& truth : context.sequence->truth) {
        if (truth.id == sample.error->truth) return &truth;
      }
    }
  }
  return nullptr;
}

std::optional<Parameters> TruthParameters(const FrameContext& context, const ObjectReport& object,
                                          double mean_azimuth_deg) {
  const SequenceView::Truth* truth = TruthOf(context);
  if (truth == nullptr) return std::nullopt;
  const UprightFrame upright(-context.sequence->up_in_world);
  for (const ModelView& model : context.sequence->models) {
    if (model.name != truth->model) continue;
    Parameters at =
        At(object.world_from_reference_cam.inverse() * (truth->world_from_object * model.center),
           upright.Azimuth(truth->world_from_object.linear()));
    const double period = 360.0 / std::max(1, model.symmetry_order);
    at.value[kAzimuth] =
        mean_azimuth_deg +
        (model.any_azimuth ? 0 : std::remainder(at.value[kAzimuth] - mean_azimuth_deg, period));
    return at;
  }
  return std::nullopt;
}

Marginals MarginalsOf(const FrameContext& context, const ObjectReport& object) {
  const std::vector<Particle>& particles = *object.particles;
  const UprightFrame upright(-context.sequence->up_in_world);
  const double around = kDegrees * upright.Azimuth(object.world_from_object.linear());
  std::vector<Parameters> places;
  std::vector<double> weights;
  double sum = 0;
  for (const Particle& p : particles) {
    const double z = std::exp(double{p.rho});
    places.push_back(At({z * p.x_c, z * p.y_c, z}, p.azimuth));
    double& azimuth = places.back().value[kAzimuth];
    azimuth = around + std::remainder(azimuth - around, 360.0);
    weights.push_back(std::exp(double{p.log_weight}));
    sum += weights.back();
  }
  Marginals result;
  result.truth = TruthParameters(context, object, around);
  for (int axis = 0; axis < 4; ++axis) {
    double mean = 0, square = 0, low = 1e9, high = -1e9;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double v = places[i].value[axis];
      mean += weights[i] / sum * v;
      square += weights[i] / sum * v * v;
      low = std::min(low, v);
      high = std::max(high, v);
    }
    const double reach = std::max(high - low, kAxes[axis].least_reach);
    // A truth not far outside widens the axis; one further off is named in words.
    if (result.truth && std::abs(result.truth->value[axis] - mean) < 2 * reach) {
      low = std::min(low, result.truth->value[axis]);
      high = std::max(high, result.truth->value[axis]);
    }
    const double middle = 0.5 * (low + high);
    const double half = 0.54 * std::max(high - low, kAxes[axis].least_reach);
    result.low[axis] = middle - half;
    result.high[axis] = middle + half;
    result.mean[axis] = mean;
    result.std[axis] = std::sqrt(std::max(0.0, square - mean * mean));
    for (std::size_t i = 0; i < places.size(); ++i) {
      const int bin =
          static_cast<int>(kBins * (places[i].value[axis] - result.low[axis]) / (2 * half));
      result.share[axis][std::clamp(bin, 0, kBins - 1)] += weights[i] / sum;
    }
  }
  return result;
}

void Words(const FrameContext& context, ImVec2 at, float align, ImU32 color,
           const std::string& words) {
  ImFont* font = context.fonts.small;
  const float width = font->CalcTextSizeA(font->FontSize, 1e6f, 0, words.c_str()).x;
  ImGui::GetWindowDrawList()->AddText(font, font->FontSize, {at.x - align * width, at.y}, color,
                                      words.c_str());
}

std::string Percent(int part, int whole) {
  return whole > 0 ? fmt::format("{:.0f} %", 100.0 * part / whole) : "\u2013";
}

class PosteriorPanel : public Panel {
 public:
  const char* Id() const override { return "posterior"; }
  const char* Title() const override { return "Belief"; }
  const char* Help() const override {
    return "How the hypotheses of the selected object spread along each parameter, in the camera "
           "of its reference time, and, where there is ground truth, whether beliefs of this run "
           "are honest: the truth should lie in half of the 50 % regions and in 95 of 100 of the "
           "95 % regions.";
  }

  void Draw(const FrameContext& context, CommandSink&) override {
    if (DrawWaiting(context)) return;
    const ObjectReport* object = context.SelectedObject();
    if (object == nullptr || object->particles == nullptr || object->particles->empty())
      return EmptyState(context, "No hypotheses",
                        "Select an object in the list, in an image or in the map.");
    ImGui::PushFont(context.fonts.small);
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const bool beside = room.x > context.Scaled(520) && room.y > context.Scaled(60);
    const float side = beside ? context.Scaled(250) : 0;
    Remember(context, *object);
    DrawMarginals(context, corner, {room.x - side, room.y});
    if (beside) {
      ImGui::SetCursorScreenPos({corner.x + room.x - side + context.Scaled(14), corner.y});
      ImGui::BeginChild("posterior.honest", {side - context.Scaled(14), room.y});
      DrawHonesty(context);
      ImGui::EndChild();
    }
    ImGui::PopFont();
  }

 private:
  void Remember(const FrameContext& context, const ObjectReport& object) {
    const RunHistory* history = context.playback->history.get();
    const bool same = version_ == context.snapshot_version && object_ == object.id;
    if (same && history_ == history) return;
    version_ = context.snapshot_version;
    object_ = object.id;
    history_ = history;
    marginals_ = MarginalsOf(context, object);
    all_ = CalibrationOf(*history);
    this_ = CalibrationOf(*history, object.id);
  }

  void DrawMarginals(const FrameContext& context, ImVec2 corner, ImVec2 room) const {
    const float gap = context.Scaled(10);
    const ImVec2 size(0.5f * (room.x - gap), 0.5f * (room.y - 0.5f * gap));
    if (size.x < 30 || size.y < 3 * context.fonts.small->FontSize) return;
    for (int axis = 0; axis < 4; ++axis) {
      DrawHistogram(context, axis,
                    {corner.x + static_cast<float>(axis % 2) * (size.x + gap),
                     corner.y + static_cast<float>(axis / 2) * (size.y + 0.5f * gap)},
                    size);
    }
  }

  void DrawHistogram(const FrameContext& context, int axis, ImVec2 corner, ImVec2 size) const {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float font = context.fonts.small->FontSize;
    const ImVec2 low(corner.x, corner.y + font + 1),
        high(corner.x + size.x, corner.y + size.y - font);
    draw.AddRectFilled(low, high, colors::kInset, context.Scaled(2));
    const auto& share = marginals_.share[axis];
    const double tallest = *std::max_element(std::begin(share), std::end(share));
    const float width = size.x / kBins;
    const ImU32 color = ObjectColor(object_);
    for (int i = 0; i < kBins; ++i) {
      const auto tall = static_cast<float>(share[i] / tallest) * (high.y - low.y - 2);
      draw.AddRectFilled({low.x + width * static_cast<float>(i), high.y - tall},
                         {low.x + width * static_cast<float>(i + 1) - 1, high.y},
                         WithAlpha(color, 0.65));
    }
    const auto x_of = [&](double v) {
      return low.x + static_cast<float>((v - marginals_.low[axis]) /
                                        (marginals_.high[axis] - marginals_.low[axis])) *
                         size.x;
    };
    const auto line = [&](double v, ImU32 ink) {
      const float x = x_of(v);
      if (x >= low.x && x <= high.x)
        draw.AddLine({x, low.y}, {x, high.y}, ink, context.Scaled(1.5));
    };
    line(marginals_.mean[axis], colors::kText);
    if (marginals_.truth) line(marginals_.truth->value[axis], colors::kTruth);
    const auto number = [&](double v) {
      return axis == kDepth ? fmt::format("{:.2f} m", std::exp(v))
                            : fmt::format("{:.1f}{}", v, kAxes[axis].unit);
    };
    const std::string spread =
        axis == kDepth ? fmt::format("{:.1f} %", 100 * marginals_.std[axis])
                       : fmt::format("{:.1f}{}", marginals_.std[axis], kAxes[axis].unit);
    Words(context, corner, 0, colors::kDimText, kAxes[axis].name);
    Words(context, {high.x, corner.y}, 1, colors::kText,
          fmt::format("{} \u00b1 {}", number(marginals_.mean[axis]), spread));
    Words(context, {low.x, high.y}, 0, colors::kFaint, number(marginals_.low[axis]));
    Words(context, {high.x, high.y}, 1, colors::kFaint, number(marginals_.high[axis]));
    if (marginals_.truth)
      Words(context, {0.5f * (low.x + high.x), high.y}, 0.5f, colors::kTruth,
            "truth " + number(marginals_.truth->value[axis]));
    ImGui::SetCursorScreenPos(corner);
    ImGui::InvisibleButton(kAxes[axis].name, size);
    LogItem(context, fmt::format("posterior.axis.{}", axis));
    Tooltip(context, std::string(kAxes[axis].help) +
                         " Bars: the particles by weight. White: their mean. Green: the truth.");
  }

  void DrawHonesty(const FrameContext& context) const {
    DimText("Is the belief honest?");
    Tooltip(context,
            "Over the frames of this run so far in which a confirmed object was weighed and a true "
            "one of its category is within 50 cm. The regions are those of a Gaussian with the "
            "belief's covariance. Frames of one object resemble one another: these are few "
            "independent trials.");
    if (all_.poses == 0) {
      ImGui::PushStyleColor(ImGuiCol_Text, colors::kFaint);
      ImGui::TextWrapped("%s", context.sequence->truth.empty()
                                   ? "Needs ground truth beside the sequence."
                                   : "No confirmed object is near a true one yet.");
      ImGui::PopStyleColor();
      return;
    }
    DrawJudgement();
    if (!ImGui::BeginTable("posterior.table", 3, ImGuiTableFlags_SizingStretchProp)) return;
    Row("truth in the", fmt::format("#{}", object_.value), "all", colors::kDimText);
    Row("50 % region", Percent(this_.within_50, this_.poses), Percent(all_.within_50, all_.poses),
        colors::kText);
    Row("95 % region", Percent(this_.within_95, this_.poses), Percent(all_.within_95, all_.poses),
        colors::kText);
    Row("shape right", Percent(this_.right(), this_.labels()), Percent(all_.right(), all_.labels()),
        colors::kText);
    Row("believed", this_.labels() > 0 ? fmt::format("{:.0f} %", 100 * this_.claimed()) : "\u2013",
        fmt::format("{:.0f} %", 100 * all_.claimed()), colors::kText);
    Row("frames", fmt::format("{}", this_.poses), fmt::format("{}", all_.poses), colors::kFaint);
    ImGui::EndTable();
  }

  void DrawJudgement() const {
    const double most = static_cast<double>(all_.within_95) / all_.poses;
    const double half = static_cast<double>(all_.within_50) / all_.poses;
    const bool too_sure = most<0.8, unsure = half> 0.8;
    ImGui::PushStyleColor(ImGuiCol_Text, too_sure ? colors::kWarning
                                         : unsure ? colors::kAccent
                                                  : colors::kGood);
    ImGui::TextUnformatted(too_sure ? "Too sure: errors exceed it."
                           : unsure ? "Cautious: errors are smaller."
                                    : "About as sure as it may be.");
    ImGui::PopStyleColor();
  }

  static void Row(const char* name, const std::string& object, const std::string& all,
                  ImU32 color) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    DimText("%s", name);
    ImGui::PushStyleColor(ImGuiCol_Text, color);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(object.c_str());
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(all.c_str());
    ImGui::PopStyleColor();
  }

  std::uint64_t version_ = 0;
  ObjectId object_;
  const RunHistory* history_ = nullptr;  ///< Compared only.
  Marginals marginals_{};
  Calibration all_, this_;
};

}  // namespace

std::unique_ptr<Panel> MakePosteriorPanel() { return std::make_unique<PosteriorPanel>(); }

}  // namespace plumbline
