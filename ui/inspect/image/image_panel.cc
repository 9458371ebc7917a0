// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/image/image_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include <opencv2/imgproc.hpp>

#include "engine/snapshot/frame_analysis.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/files/kept_value.h"
#include "ui/framework/image_canvas.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/image/overlays.h"
#include "ui/inspect/truth/truths.h"

namespace plumbline {
namespace {

ImU32 FateColor(const FrameContext& context, const ProposalReport& proposal) {
  switch (proposal.fate) {
    case ProposalFate::kExplained:
      return context.ColorOf(proposal.object);
    case ProposalFate::kSpawned:
      return IM_COL32_WHITE;
    case ProposalFate::kUnknownCategory:
      return IM_COL32(150, 158, 170, 255);
    case ProposalFate::kLowScore:
      return IM_COL32(108, 116, 128, 255);
    case ProposalFate::kImplausible:
      return colors::kBad;
  }
  return colors::kDimText;
}

bool IsWeak(const ProposalReport& proposal) {
  return proposal.fate == ProposalFate::kLowScore ||
         proposal.fate == ProposalFate::kUnknownCategory;
}

/// Whether a proposal is drawn while only confirmed objects are asked for: if one of them explains
/// it.
bool IsOfShownObject(const FrameContext& context, const ProposalReport& proposal) {
  if (!context.confirmed_only) return true;
  for (const ObjectReport& object : context.snapshot->report.objects) {
    if (object.id == proposal.object) return context.Shows(object);
  }
  return false;
}

class ImagePanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    float width = context.Scaled(26);
    for (const char* label :
         {"Scores", "Proposals", "Weak", "Outlines", "Names", "Particles", "Contour", "Truth"}) {
      width += ToggleWidth(context, label);
    }
    const bool own_poses = context.sequence != nullptr && context.sequence->own_poses != nullptr;
    if (own_poses) width += ToggleWidth(context, "Tracks") + context.Scaled(4);
    AlignRight(width);
    if (own_poses) {
      Toggle(context, "image.tracks", "Tracks", tracks_,
             "Points that the visual-inertial filter follows: green in its state, red turned away "
             "by the gate, grey followed only; the larger, the longer.");
      ImGui::SameLine();
    }
    Toggle(context, "image.scores", "Scores", scores_,
           "Top-down: what the run's detector scores for a box as large as the selected object's, "
           "of its category, at every place. Yellow is the highest in the image; point at a place "
           "for its "
           "score.");
    ImGui::SameLine();
    Toggle(context, "image.proposals", "Proposals", proposals_,
           "Boxes that the detector proposes, with category and score. In an object's colour: "
           "explained by it (of several, the best is labelled). White: spawned an object. "
           "Red: no plausible place for a model in the box.");
    ImGui::SameLine();
    Toggle(context, "image.weak", "Weak", weak_,
           "Also the proposals that were not used: of categories without a model (light grey) and "
           "of low score (dark grey). Point at a box's edge for what it is.");
    ImGui::SameLine();
    Toggle(context, "image.outlines", "Outlines", outlines_,
           "Outline of each object's mean state, in its colour.");
    ImGui::SameLine();
    Toggle(
        context, "image.names", "Names", names_,
        "Number and most likely model of each object, as far as there is room; of tentative ones "
        "the number alone. Point at an object for its name.");
    ImGui::SameLine();
    Toggle(context, "image.particles", "Particles", particles_,
           "Centres of the selected object's hypotheses.");
    ImGui::SameLine();
    Toggle(context, "image.contour", "Contour", contour_,
           "Contour samples of the hypothesis that is chosen under 'Why here?', with their search "
           "lines and the edges that they hit: green hits well, red misses, grey is hidden, or "
           "before something known that is as dark.");
    ImGui::SameLine();
    Toggle(
        context, "image.truth", "Truth", truth_,
        "Where the true objects show, and their names; dashed: the map lacks it in this frame. A "
        "click selects one.");
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const MapSnapshot& snapshot = *context.snapshot;
    if (snapshot.image.empty()) {
      return EmptyState(context, "No image",
                        snapshot.report.skipped.empty() ? "This frame came without an image."
                                                        : snapshot.report.skipped.c_str());
    }
    const ImTextureID texture =
        context.textures->Get("image", context.snapshot_version, [&] { return snapshot.image; });
    const ImageCanvas canvas(context, "image.view", texture, context.sequence->image_width,
                             context.sequence->image_height);
    if (scores_) {
      sink.Post(NeedCommand{NeedCommand::What::kScoreMap, {}});
      DrawScoreMap(context, canvas);
    }
    if (tracks_) DrawTrackOverlay(context, canvas);
    if (proposals_) DrawProposals(context, canvas);
    if (outlines_) DrawOutlineOverlay(context, canvas, {});
    if (const ObjectReport* object = context.SelectedObject(); particles_ && object != nullptr) {
      DrawParticleOverlay(context, canvas, *object, {});
    }
    if (contour_) DrawContourOverlay(context, canvas);
    DrawParticleOutline(context, canvas);
    DrawTruthOverlay(context, canvas, truth_);
    PictureLabels labels(context, canvas.low(), canvas.high());
    if (!snapshot.report.skipped.empty()) {
      labels.Add({canvas.low()}, colors::kWarning, "not used: " + snapshot.report.skipped);
    }
    if (names_) LabelObjects(context, canvas, labels);
    if (proposals_) LabelProposals(context, canvas, labels);
    LabelTruths(context, canvas, truth_, labels);
    if (scores_) LabelScores(context, canvas, labels);
    DrawPixelValue(context, canvas);
    if (const auto pixel = canvas.clicked()) {
      const ObjectId object = ObjectAt(context, *pixel);
      const std::string truth = truth_ ? TruthAt(context, *pixel) : "";
      if (object.value > 0 || truth.empty())
        sink.Post(SelectObjectCommand{object});
      else
        sink.Post(SelectTruthCommand{truth});
    }
  }

  nlohmann::json SaveState() const override {
    return {{"proposals", proposals_}, {"weak", weak_},           {"outlines", outlines_},
            {"names", names_},         {"particles", particles_}, {"contour", contour_},
            {"tracks", tracks_},       {"scores", scores_},       {"truth", truth_}};
  }
  void LoadState(const nlohmann::json& json) override {
    proposals_ = KeptValue(json, "proposals", proposals_);
    weak_ = KeptValue(json, "weak", weak_);
    outlines_ = KeptValue(json, "outlines", outlines_);
    names_ = KeptValue(json, "names", names_);
    particles_ = KeptValue(json, "particles", particles_);
    contour_ = KeptValue(json, "contour", contour_);
    tracks_ = KeptValue(json, "tracks", tracks_);
    scores_ = KeptValue(json, "scores", scores_);
    truth_ = KeptValue(json, "truth", truth_);
  }

 private:
  /// Of the selected object in this frame; null while it is worked out.
  static const ScoreMap* Scores(const FrameContext& context) {
    const bool ready = context.analysis != nullptr && context.analysis->score_map &&
                       context.analysis->object == context.selection.object;
    return ready ? &*context.analysis->score_map : nullptr;
  }

  static void DrawScoreMap(const FrameContext& context, const ImageCanvas& canvas) {
    const ScoreMap* map = Scores(context);
    if (map == nullptr || map->scores.empty()) return;
    const std::string name = "score map of #" + std::to_string(context.selection.object.value);
    const ImTextureID texture = context.textures->Get(name, context.snapshot_version, [&] {
      cv::Mat levels, picture;
      cv::normalize(map->scores, levels, 255, 0, cv::NORM_INF, CV_8UC1);
      cv::applyColorMap(levels, picture, cv::COLORMAP_VIRIDIS);
      return picture;
    });
    const float reach = 0.5f * static_cast<float>(map->step_px);
    const auto step = static_cast<float>(map->step_px);
    constexpr int kOpacity = 165;  // of 255: the image shines through
    canvas.draw().AddImage(texture, canvas.ToScreen(-reach, -reach),
                           canvas.ToScreen(static_cast<float>(map->scores.cols - 1) * step + reach,
                                           static_cast<float>(map->scores.rows - 1) * step + reach),
                           {0, 0}, {1, 1}, IM_COL32(255, 255, 255, kOpacity));
    if (const auto pixel = canvas.hovered()) {
      const int column = std::clamp(cvRound(pixel->x() / step), 0, map->scores.cols - 1);
      const int row = std::clamp(cvRound(pixel->y() / step), 0, map->scores.rows - 1);
      const auto x = static_cast<float>(column) * step, y = static_cast<float>(row) * step;
      const auto half_width = static_cast<float>(map->width_px / 2);
      const auto half_height = static_cast<float>(map->height_px / 2);
      const ImVec2 low = canvas.ToScreen(x - half_width, y - half_height),
                   high = canvas.ToScreen(x + half_width, y + half_height);
      canvas.draw().AddRect(low, high, IM_COL32(255, 255, 255, 200), 0, 0, context.Scaled(1.0));
      PutTooltipBeside(context, low, high);
      ImGui::SetTooltip("%s in this box: %.2f", map->category.c_str(),
                        static_cast<double>(map->scores.at<float>(row, column)));
    }
  }

  static void LabelScores(const FrameContext& context, const ImageCanvas& canvas,
                          PictureLabels& labels) {
    const ScoreMap* map = Scores(context);
    std::string text = "scoring boxes ..";
    if (map != nullptr) {
      double highest = 0;
      if (!map->scores.empty()) cv::minMaxLoc(map->scores, nullptr, &highest);
      text = !map->problem.empty()
                 ? map->problem
                 : fmt::format("{} boxes of {:.0f} x {:.0f} px: at most {:.2f}", map->category,
                               map->width_px, map->height_px, highest);
    }
    const ImVec2 size = labels.SizeOf(text);
    labels.Add({{canvas.low().x, canvas.high().y}, {canvas.low().x, canvas.low().y + size.y}},
               map != nullptr && !map->problem.empty() ? colors::kWarning : colors::kText, text);
  }

  void DrawProposals(const FrameContext& context, const ImageCanvas& canvas) const {
    for (const ProposalReport& proposal : context.snapshot->report.proposals) {
      const ImVec2 low = canvas.ToScreen(proposal.box.x0 - 0.5f, proposal.box.y0 - 0.5f);
      const ImVec2 high = canvas.ToScreen(proposal.box.x1 + 0.5f, proposal.box.y1 + 0.5f);
      const bool weak = IsWeak(proposal);
      if ((weak && !weak_) || !IsOfShownObject(context, proposal)) continue;
      const ImU32 color = FateColor(context, proposal);
      canvas.draw().AddRect(low, high, IM_COL32(0, 0, 0, 130), 0, 0,
                            context.Scaled(weak ? 2.0 : 3.0));
      canvas.draw().AddRect(low, high, color, 0, 0, context.Scaled(weak ? 1.0 : 1.5));
      const float edge = context.Scaled(6);
      if (canvas.hovered() && (ImGui::IsMouseHoveringRect(low, {high.x, low.y + edge}) ||
                               ImGui::IsMouseHoveringRect(low, {low.x + edge, high.y}))) {
        std::string why = InWords(NameOf(proposal.fate));
        if (proposal.object.value > 0) why += fmt::format(" (object #{})", proposal.object.value);
        PutTooltipBeside(context, low, high);
        ImGui::SetTooltip("%s, score %.2f\n%s", proposal.category.c_str(), proposal.score,
                          why.c_str());
      }
    }
  }

  void LabelProposals(const FrameContext& context, const ImageCanvas& canvas,
                      PictureLabels& labels) const {
    std::set<ObjectId> labelled;  // proposals come by falling score: the first is the best
    for (const ProposalReport& proposal : context.snapshot->report.proposals) {
      if (IsWeak(proposal) || !IsOfShownObject(context, proposal)) continue;
      if (proposal.object.value > 0 && !labelled.insert(proposal.object).second) continue;
      const std::string text = fmt::format("{} {:.2f}", proposal.category, proposal.score);
      const ImVec2 size = labels.SizeOf(text);
      const ImVec2 low = canvas.ToScreen(proposal.box.x0 - 0.5f, proposal.box.y0 - 0.5f);
      const ImVec2 high = canvas.ToScreen(proposal.box.x1 + 0.5f, proposal.box.y1 + 0.5f);
      labels.Add({low,
                  {high.x - size.x, low.y},
                  {low.x, high.y + size.y},
                  {high.x - size.x, high.y + size.y},
                  {low.x, low.y + size.y}},
                 FateColor(context, proposal), text, PictureLabels::Need::kIfFree);
    }
  }

  /// The selected object's name, then those of confirmed ones, the larger first, then the numbers
  /// of the others: what comes late has less room.
  static void LabelObjects(const FrameContext& context, const ImageCanvas& canvas,
                           PictureLabels& labels) {
    std::vector<const ObjectReport*> named;
    for (const ObjectReport& object : context.snapshot->report.objects) {
      if (!object.visible_box.empty() && object.state != ObjectState::kRetired &&
          context.Shows(object))
        named.push_back(&object);
    }
    const auto rank = [&](const ObjectReport* object) {
      return std::tuple(object->id != context.selection.object,
                        object->state != ObjectState::kConfirmed,
                        -object->visible_box.width() * object->visible_box.height());
    };
    std::stable_sort(named.begin(), named.end(), [&](const ObjectReport* a, const ObjectReport* b) {
      return rank(a) < rank(b);
    });
    for (const ObjectReport* object : named) LabelObject(context, canvas, *object, labels);
  }

  static void LabelObject(const FrameContext& context, const ImageCanvas& canvas,
                          const ObjectReport& object, PictureLabels& labels) {
    const bool selected = object.id == context.selection.object;
    const ModelView* model = context.Model(object.label);
    std::string text = fmt::format("#{}", object.id.value);
    if (selected || object.state == ObjectState::kConfirmed)
      text += " " + (model != nullptr ? model->name : object.category);
    const ImVec2 size = labels.SizeOf(text);
    const Box2& box = object.visible_box;
    const ImVec2 center = canvas.ToScreen(box.center_x(), box.center_y());
    const ImVec2 low = canvas.ToScreen(box.x0, box.y0), high = canvas.ToScreen(box.x1, box.y1);
    const float x = center.x - 0.5f * size.x, y = center.y + 0.5f * size.y;
    labels.Add({{x, y},
                {x, y + 1.1f * size.y},
                {x, y - 1.1f * size.y},
                {x, y + 2.2f * size.y},
                {x, y - 2.2f * size.y},
                {low.x, y},
                {high.x - size.x, y},
                {low.x, high.y},
                {high.x - size.x, high.y},
                {low.x, low.y + size.y},
                {high.x - size.x, low.y + size.y}},
               context.ColorOf(object.id), text,
               selected ? PictureLabels::Need::kAlways : PictureLabels::Need::kIfFree);
  }

  bool proposals_ = true, weak_ = false, outlines_ = true, names_ = true, particles_ = false,
       contour_ = true, tracks_ = true, scores_ = false, truth_ = false;
};

}  // namespace

ActionGroup ImageViewActions() {
  ActionGroup group{"Image views", {}};
  for (int count = 1; count <= 5; ++count)
    group.actions.push_back(
        {.text = fmt::format("Image views: {}", count), .run = Posts(ImageViewsCommand{count})});
  return group;
}

std::unique_ptr<Panel> MakeImagePanel() { return std::make_unique<ImagePanel>(); }

}  // namespace plumbline
