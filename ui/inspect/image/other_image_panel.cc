// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/image/other_image_panel.h"

#include <filesystem>

#include "ui/common/waiting.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/image/image_panel.h"

namespace plumbline {
namespace {

/// Textures of the other run under names of their own.
class OtherTextures : public TextureStore {
 public:
  explicit OtherTextures(TextureStore& store) : store_(store) {}
  ImTextureID Get(std::string_view name, std::uint64_t version,
                  const std::function<cv::Mat()>& make) override {
    return store_.Get("other run, " + std::string(name), version, make);
  }

 private:
  TextureStore& store_;
};

class OtherImagePanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    if (context.other == nullptr) return;
    DimText("%s", std::filesystem::path(context.other->source).filename().c_str());
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (context.other == nullptr || DrawWaiting(context)) return;
    const OtherRun& other = *context.other;
    if (other.playback->state == PlaybackState::kFailed)
      return EmptyState(context, "The other run cannot be shown", other.playback->message.c_str());
    if (other.snapshot == nullptr)
      return EmptyState(context, "Opening the other run", other.source.c_str());
    OtherTextures textures(*context.textures);
    WidgetLog widgets;
    FrameContext shown = context;
    shown.textures = &textures;
    shown.widgets = &widgets;
    shown.sequence = other.sequence;
    shown.snapshot = other.snapshot;
    shown.playback = other.playback;
    shown.looks = other.looks;
    shown.snapshot_version = other.version;
    shown.probe = nullptr;
    image_->Draw(shown, sink);
    for (const auto& [name, rect] : widgets.rects())
      context.widgets->Add("other." + name, rect.low, rect.high);
  }

  void LoadState(const nlohmann::json& json) override { image_->LoadState(json); }

 private:
  std::unique_ptr<Panel> image_ = MakeImagePanel();
};

}  // namespace

std::unique_ptr<Panel> MakeOtherImagePanel() { return std::make_unique<OtherImagePanel>(); }

}  // namespace plumbline
