// SPDX-License-Identifier: Apache-2.0
#include "tests/ui/panel_harness.h"

#include <algorithm>
#include <stdexcept>

#include "tests/support/fake_source.h"
#include "ui/framework/layout.h"

namespace plumbline {

ImTextureID CheckingTextures::Get(std::string_view name, std::uint64_t version,
                                  const std::function<cv::Mat()>& make) {
  const auto known = versions_.find(name);
  if (known != versions_.end() && known->second == version) return nullptr;
  versions_.insert_or_assign(std::string(name), version);
  const cv::Mat picture = make();
  if (picture.type() != CV_8UC3)
    throw std::runtime_error(std::string(name) + " is not a BGR picture");
  ++pictures_made;
  return nullptr;
}

PanelHarness::PanelHarness() {
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.DisplaySize = {1000, 800};
  io.DeltaTime = 1.0f / 60;
  io.MousePos = {-1, -1};
  context.fonts = ApplyTheme(1.0);
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  context.playback = std::make_shared<const PlaybackView>();
  context.textures = &textures;
  context.widgets = &widgets;
  context.viewport = &viewport;
  context.scene = &scene;
  context.renderer = "none";
}

PanelHarness::~PanelHarness() { ImGui::DestroyContext(); }

void PanelHarness::ShowFrame(int frame) {
  if (source_ == nullptr) {
    source_ = MakeFakeSource(
        {.num_frames = 60, .width = 160, .height = 90, .particles = 20, .recorded = true});
    context.sequence = std::make_shared<const SequenceView>(source_->view());
  }
  context.snapshot = source_->Past(frame, {}).value();
  ++context.snapshot_version;
  PlaybackView playback;
  playback.frame = frame;
  playback.newest_mapped_frame = 40;
  playback.events = std::make_shared<const std::vector<FrameEvent>>(source_->events());
  context.playback = std::make_shared<const PlaybackView>(playback);
}

void PanelHarness::Analyse(const MapperOptions& options, WatchCommand also) {
  FrameAnalyst analyst;
  also.object = context.selection.object;
  also.history = also.relations = true;
  analyst.Watch(also);
  context.analysis = analyst.OfFrame(context.snapshot, *context.sequence, options);
  context.history = analyst.OfHistory(*context.playback->history, *context.sequence);
}

void PanelHarness::Draw(Panel& panel, int frames) {
  for (int i = 0; i < frames; ++i) {
    ImGui::NewFrame();
    widgets.Clear();
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize(ImGui::GetIO().DisplaySize);
    ImGui::Begin("test", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove);
    DrawPanel(context, {{20, 20}, {20 + size.x, 20 + size.y}}, panel, sink);
    ImGui::End();
    ImGui::Render();
    vertices = ImGui::GetDrawData()->TotalVtxCount;
  }
}

ImVec2 PanelHarness::At(const std::string& widget, float x, float y) const {
  const WidgetLog::Rect* rect = widgets.Find(widget);
  if (rect == nullptr) throw std::runtime_error("the panel shows no " + widget);
  return {rect->low.x + x * (rect->high.x - rect->low.x),
          rect->low.y + y * (rect->high.y - rect->low.y)};
}

void PanelHarness::Point(Panel& panel, const std::string& widget, float x, float y) {
  Draw(panel);
  ImGui::GetIO().MousePos = At(widget, x, y);
  Draw(panel, 2);
}

void PanelHarness::Click(Panel& panel, const std::string& widget, float x, float y) {
  Point(panel, widget, x, y);
  ImGui::GetIO().MouseDown[0] = true;
  Draw(panel);
  ImGui::GetIO().MouseDown[0] = false;
  Draw(panel, 2);
}

void PanelHarness::Drag(Panel& panel, const std::string& widget, ImVec2 from, ImVec2 to,
                        int button) {
  Point(panel, widget, from.x, from.y);
  ImGui::GetIO().MouseDown[button] = true;
  Draw(panel);
  ImGui::GetIO().MousePos = At(widget, to.x, to.y);
  Draw(panel);
  ImGui::GetIO().MouseDown[button] = false;
  Draw(panel);
}

void PanelHarness::JumpAndClick(Panel& panel, const std::string& widget, ImVec2 share,
                                ImVec2 tremor_px, int button) {
  Point(panel, widget, 0.1f, 0.1f);
  ImGuiIO& io = ImGui::GetIO();
  io.MousePos = At(widget, share.x, share.y);
  io.MouseDown[button] = true;
  Draw(panel);
  io.MousePos = {io.MousePos.x + tremor_px.x, io.MousePos.y + tremor_px.y};
  Draw(panel);
  io.MouseDown[button] = false;
  Draw(panel, 2);
}

void PanelHarness::Wheel(Panel& panel, const std::string& widget, float notches) {
  Point(panel, widget);
  ImGui::GetIO().MouseWheel = notches;
  Draw(panel);
  ImGui::GetIO().MouseWheel = 0;
  Draw(panel);
}

}  // namespace plumbline
