// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_view_menu.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

struct ColoringEntry {
  ScanColoring coloring;
  const char* label;
  const char* help;
};
constexpr ColoringEntry kColorings[] = {
    {ScanColoring::kOwn, "Its own", "The colours that the scan came with."},
    {ScanColoring::kHeight, "Height", "From dark, low, to bright, high."},
    {ScanColoring::kNormal, "Normal",
     "How the surface is turned: floors and tops are blue, walls red and green."}};

bool Offered(const FrameContext& context, ScanColoring coloring) {
  const TriangleMesh* scan = context.annotation->scan.get();
  if (scan == nullptr || scan->empty()) return false;
  const std::size_t count = scan->vertices.size();
  if (coloring == ScanColoring::kOwn) return scan->colors.size() == count;
  if (coloring == ScanColoring::kNormal)
    return !scan->triangles.empty() || scan->normals.size() == count;
  return true;
}

ScanColoring Shown(const FrameContext& context) {
  const std::optional<ScanColoring>& chosen = context.annotate->scan_look.coloring;
  if (chosen && Offered(context, *chosen)) return *chosen;
  const bool own = !chosen && Offered(context, ScanColoring::kOwn);
  return own ? ScanColoring::kOwn : ScanColoring::kHeight;
}

void DrawColors(const FrameContext& context) {
  DimText("Colours of the scan");
  bool first = true;
  for (const ColoringEntry& entry : kColorings) {
    if (!first) ImGui::SameLine(0, context.Scaled(3));
    first = false;
    const bool offered = Offered(context, entry.coloring);
    ImGui::BeginDisabled(!offered);
    bool on = Shown(context) == entry.coloring;
    if (Toggle(context, std::string("looks.") + KeyOf(entry.coloring), entry.label, on,
               offered ? entry.help : "This scan has none."))
      context.annotate->scan_look.coloring = entry.coloring;
    ImGui::EndDisabled();
  }
  const TriangleMesh* scan = context.annotation->scan.get();
  if (scan == nullptr || !scan->triangles.empty()) return;
  DimText("Points");
  ImGui::SameLine(context.Scaled(70));
  ImGui::SetNextItemWidth(context.Scaled(140));
  ImGui::SliderFloat("##looks.points", &context.annotate->scan_look.point_px, kFewestPx, kMostPx,
                     "%.1f px");
  LogItem(context, "looks.points");
}

/// "View 3", or what was typed; a name that is there already stands for the new view.
void KeepView(const FrameContext& context) {
  AnnotateView& view = *context.annotate;
  std::string name = view.view_name;
  const auto find = [&] {
    return std::find_if(view.saved_views.begin(), view.saved_views.end(),
                        [&](const SavedView& saved) { return saved.name == name; });
  };
  for (int i = 1; name.empty() || (view.view_name.empty() && find() != view.saved_views.end()); ++i)
    name = fmt::format("View {}", i);
  if (find() != view.saved_views.end())
    find()->camera = context.annotate_scene->camera();
  else if (view.saved_views.size() < kMostViews)
    view.saved_views.push_back({name, context.annotate_scene->camera()});
  view.view_name.clear();
}

void DrawSavedViews(const FrameContext& context) {
  AnnotateView& view = *context.annotate;
  DimText("Views to come back to");
  const float width = context.Scaled(190);
  std::optional<std::size_t> removed;
  for (std::size_t i = 0; i < view.saved_views.size(); ++i) {
    const SavedView& saved = view.saved_views[i];
    const std::string name = fmt::format("looks.view.{}", i);
    ImGui::AlignTextToFramePadding();
    if (ImGui::Selectable(fmt::format("{}##{}", saved.name, name).c_str(), false, 0, {width, 0})) {
      context.annotate_scene->SetCamera(saved.camera);
      ImGui::CloseCurrentPopup();
    }
    LogItem(context, name);
    ImGui::SameLine();
    bool off = false;
    if (Toggle(context, fmt::format("looks.forget.{}", i), "Forget", off, "Removes it."))
      removed = i;
  }
  if (removed)
    view.saved_views.erase(view.saved_views.begin() + static_cast<std::ptrdiff_t>(*removed));
  char typed[64];
  std::snprintf(typed, sizeof(typed), "%s", view.view_name.c_str());
  ImGui::SetNextItemWidth(width);
  const bool entered =
      ImGui::InputTextWithHint("##looks.name", "name of this view", typed, sizeof(typed),
                               ImGuiInputTextFlags_EnterReturnsTrue);
  LogItem(context, "looks.name");
  view.view_name = typed;
  ImGui::SameLine();
  const bool pressed = Button(context, "looks.keep", "Keep",
                              "Keeps where the view looks from, for this scan; without a name it "
                              "gets a number. The palette (Ctrl+P) goes there, too.");
  if (entered || pressed) KeepView(context);
}

}  // namespace

void DrawViewMenu(const FrameContext& context) {
  DrawColors(context);
  ImGui::Separator();
  ImGui::BeginDisabled(!context.annotation->has_sequence);
  Toggle(
      context, "looks.masks", "Masks in a frame", context.annotate->masks,
      "Below the scan: which object shows at which pixel of a frame, as exported masks have it.");
  ImGui::EndDisabled();
  ImGui::Separator();
  if (context.annotate_scene != nullptr) DrawSavedViews(context);
}

void AddViewEntries(const FrameContext& context, std::vector<PaletteEntry>& entries) {
  if (context.annotate == nullptr || context.annotate_scene == nullptr) return;
  for (const SavedView& saved : context.annotate->saved_views)
    entries.push_back({"View: " + saved.name, "",
                       [scene = context.annotate_scene, camera = saved.camera](CommandSink&) {
                         scene->SetCamera(camera);
                       }});
  if (context.annotation->has_sequence)
    entries.push_back(
        {context.annotate->masks ? "View: images of the selected object" : "View: masks in a frame",
         "", [view = context.annotate](CommandSink&) { view->masks = !view->masks; }});
  entries.push_back({"View: keep this one", "", [&context](CommandSink&) { KeepView(context); }});
  for (const ColoringEntry& entry : kColorings) {
    if (!Offered(context, entry.coloring)) continue;
    entries.push_back({std::string("Colours of the scan: ") + entry.label, "",
                       [view = context.annotate, coloring = entry.coloring](CommandSink&) {
                         view->scan_look.coloring = coloring;
                       }});
  }
}

}  // namespace plumbline
