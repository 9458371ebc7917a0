// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr ImU32 kLine = IM_COL32(120, 255, 160, 255), kHidden = IM_COL32(255, 210, 120, 200);
constexpr float kDash_px = 5;

/// Green where outlines lie on edges, over yellow to red.
ImU32 ScoreColor(double agreement) {
  const double share = std::clamp(agreement / 0.6, 0.0, 1.0);
  return share < 0.5 ? Mixed(colors::kBad, colors::kWarning, 2 * share)
                     : Mixed(colors::kWarning, colors::kGood, 2 * share - 1);
}

/// The part of an image around an outline, in the shape of the cell.
struct Part {
  float x0 = 0, y0 = 0, width = 1, height = 1;
};

Eigen::AlignedBox2f BoundsOf(const ImageCheckView& check) {
  Eigen::AlignedBox2f bounds;
  for (const OutlineLine& line : check.lines) {
    for (const Eigen::Vector2f& p : line.pixels) bounds.extend(p);
  }
  return bounds;
}

Part PartOf(const ImageCheckView& check, float aspect) {
  const auto columns = static_cast<float>(check.image.cols),
             rows = static_cast<float>(check.image.rows);
  Eigen::AlignedBox2f bounds = BoundsOf(check);
  if (bounds.isEmpty()) bounds = {Eigen::Vector2f(0, 0), Eigen::Vector2f(columns, rows)};
  const float x0 = bounds.min().x(), y0 = bounds.min().y(), x1 = bounds.max().x(),
              y1 = bounds.max().y();
  constexpr float kMargin = 0.25f, kLeast_px = 60;
  float width = std::max((1 + 2 * kMargin) * (x1 - x0), kLeast_px);
  float height = std::max((1 + 2 * kMargin) * (y1 - y0), kLeast_px);
  width = std::max(width, aspect * height);
  height = width / aspect;
  const float shrink = std::min({1.0f, columns / width, rows / height});
  width *= shrink;
  height *= shrink;
  const float x = std::clamp(0.5f * (x0 + x1 - width), 0.0f, columns - width);
  const float y = std::clamp(0.5f * (y0 + y1 - height), 0.0f, rows - height);
  return {x, y, width, height};
}

/// So that the pictures are about as wide as they are high.
int BestRows(int count, ImVec2 room) {
  int best = 1;
  double least = 1e9;
  for (int rows = 1; rows <= std::min(count, 4); ++rows) {
    const int columns = (count + rows - 1) / rows;
    const double aspect = room.x / columns / std::max(1.0, static_cast<double>(room.y) / rows);
    const double off = std::abs(std::log(aspect / 1.1));
    if (off >= least) continue;
    least = off;
    best = rows;
  }
  return best;
}

struct OtherStyle {
  ImU32 color;
  const char* name;
};
OtherStyle StyleOf(const OtherOutline& other) {
  if (!other.by) return {IM_COL32(255, 255, 255, 190), "where it is placed"};
  return *other.by == RefineBy::kScan ? OtherStyle{IM_COL32(90, 190, 255, 255), "by the scan"}
                                      : OtherStyle{IM_COL32(255, 150, 60, 255), "by the images"};
}

class AnnotateImagesPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    const auto& checks = context.annotation->checks;
    if (!checks || checks->images.empty()) return;
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + context.Scaled(3));
    SmallText(context, ScoreColor(checks->agreement), "%.0f %% of the outline on edges",
              100 * checks->agreement);
    Tooltip(context, "Above chance level; mean over the images.");
    for (const OtherOutline& other : checks->images.front().others) {
      const OtherStyle style = StyleOf(other);
      ImGui::SameLine(0, context.Scaled(10));
      SmallText(context, colors::kDimText, "\u2014");
      const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
      const float y = std::round(0.5f * (low.y + high.y));
      ImGui::GetWindowDrawList()->AddRectFilled({low.x, y - context.Scaled(1.5)},
                                                {high.x, y + context.Scaled(1.5)}, style.color);
      ImGui::SameLine(0, context.Scaled(4));
      SmallText(context, colors::kDimText, "%s", style.name);
    }
  }

  void Draw(const FrameContext& context, CommandSink&) override {
    const AnnotationSnapshot& snapshot = *context.annotation;
    const auto& checks = snapshot.checks;
    if (!checks) {
      return EmptyState(context, "Nothing is selected",
                        "Select an object to see its outline in the images.");
    }
    if (checks->images.empty()) {
      return EmptyState(context, checks->running ? "Choosing key frames" : "No images",
                        checks->problem.c_str());
    }
    const int count = static_cast<int>(checks->images.size());
    const float gap = context.Scaled(6);
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const int rows = BestRows(count, room), columns = (count + rows - 1) / rows;
    const auto share = [&](float all, int parts) {
      return std::floor((all - gap * static_cast<float>(parts - 1)) / static_cast<float>(parts));
    };
    const ImVec2 size(share(room.x, columns), share(room.y, rows));
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {gap, gap});
    for (int i = 0; i < count; ++i) {
      if (i % columns > 0) ImGui::SameLine(0, gap);
      const auto k = static_cast<std::size_t>(i);
      DrawImage(context, checks->images[k], k, size);
    }
    ImGui::PopStyleVar();
  }

 private:
  /// The picture stands still while the outline moves in it, as long as it stays inside.
  const Part& Shown(const FrameContext& context, const ImageCheckView& check, std::size_t index,
                    float aspect) {
    if (parts_of_ != context.annotation->images_number) parts_.clear();
    parts_of_ = context.annotation->images_number;
    if (parts_.size() <= index) parts_.resize(index + 1);
    Part& part = parts_[index];
    const Eigen::AlignedBox2f bounds = BoundsOf(check);
    const bool inside =
        bounds.isEmpty() ||
        Eigen::AlignedBox2f(Eigen::Vector2f(part.x0, part.y0),
                            Eigen::Vector2f(part.x0 + part.width, part.y0 + part.height))
            .contains(bounds);
    const bool same_shape = std::abs(part.width / part.height - aspect) < 0.01f * aspect;
    if (!inside || !same_shape) part = PartOf(check, aspect);
    return part;
  }

  void DrawImage(const FrameContext& context, const ImageCheckView& check, std::size_t index,
                 ImVec2 size) {
    if (size.x < 8 || size.y < 8 || check.image.empty()) return;
    const std::string name = fmt::format("images.{}", index);
    const ImVec2 low = ImGui::GetCursorScreenPos(), high(low.x + size.x, low.y + size.y);
    if (ImGui::InvisibleButton(name.c_str(), size)) {
      context.annotate->look_from = check.scan_from_cam.translation();
    }
    LogItem(context, name);
    Tooltip(context,
            fmt::format("Frame {}: {:.0f} % of the visible outline on edges, median {:.1f} "
                        "px off.{} Click: look from there.",
                        check.frame, 100 * check.agreement, check.median_offset_px,
                        check.held_out ? " Refining does not look at it: it judges." : ""));
    const Part part = Shown(context, check, index, size.x / size.y);
    const auto columns = static_cast<float>(check.image.cols),
               rows = static_cast<float>(check.image.rows);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    if (context.textures != nullptr) {
      const ImTextureID texture = context.textures->Get(name, context.annotation->images_number,
                                                        [&] { return check.image; });
      draw.AddImageRounded(texture, low, high, {part.x0 / columns, part.y0 / rows},
                           {(part.x0 + part.width) / columns, (part.y0 + part.height) / rows},
                           IM_COL32_WHITE, context.Scaled(4));
    }
    draw.PushClipRect(low, high, true);
    const float scale = size.x / part.width;
    const auto on_screen = [&](const std::vector<Eigen::Vector2f>& pixels) {
      std::vector<ImVec2> points;
      for (const Eigen::Vector2f& p : pixels) {
        points.emplace_back(low.x + (p.x() - part.x0 + 0.5f) * scale,
                            low.y + (p.y() - part.y0 + 0.5f) * scale);
      }
      return points;
    };
    for (const OtherOutline& other : check.others) {
      for (const auto& line : other.lines) {
        const std::vector<ImVec2> points = on_screen(line);
        draw.AddPolyline(points.data(), static_cast<int>(points.size()), StyleOf(other).color, 0,
                         context.Scaled(1.2));
      }
    }
    for (const OutlineLine& line : check.lines) {
      const std::vector<ImVec2> points = on_screen(line.pixels);
      if (line.hidden) {
        DrawDashed(draw, points, context.Scaled(kDash_px));
      } else {
        draw.AddPolyline(points.data(), static_cast<int>(points.size()),
                         WithAlpha(kLine, line.crease ? 0.45 : 0.95), 0,
                         context.Scaled(line.crease ? 1 : 1.6));
      }
    }
    draw.AddRectFilled(
        {low.x, high.y - context.Scaled(4)},
        {low.x + size.x * static_cast<float>(std::clamp(check.agreement, 0.0, 1.0)), high.y},
        ScoreColor(check.agreement));
    draw.PopClipRect();
    PictureLabels labels(context, low, high);
    labels.Add({{low.x + context.Scaled(4), low.y + context.Scaled(22)}}, colors::kOnPicture,
               fmt::format("{}   {:.0f} %{}", check.frame, 100 * check.agreement,
                           check.held_out ? "   held out" : ""));
  }

  static void DrawDashed(ImDrawList& draw, const std::vector<ImVec2>& points, float dash) {
    float along = 0;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const ImVec2 a = points[i], b = points[i + 1];
      const float length = std::hypot(b.x - a.x, b.y - a.y);
      for (float at = 0; at < length;) {
        const float phase = std::fmod(along + at, 2 * dash);
        const float step = std::min((phase < dash ? dash : 2 * dash) - phase + 0.01f, length - at);
        if (phase < dash) {
          const float s = at / length, t = (at + step) / length;
          draw.AddLine({a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)},
                       {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}, kHidden, 1.0f);
        }
        at += step;
      }
      along += length;
    }
  }

  std::vector<Part> parts_;
  std::uint64_t parts_of_ = 0;  ///< Number of the images that they are of.
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateImagesPanel() { return std::make_unique<AnnotateImagesPanel>(); }

}  // namespace plumbline
