// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/image/masks_panel.h"

#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/framework/image_canvas.h"
#include "ui/framework/pictures.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/image/overlays.h"

namespace plumbline {
namespace {

class MasksPanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const MapSnapshot& snapshot = *context.snapshot;
    if (snapshot.image.empty())
      return EmptyState(context, "No image", "This frame came without an image.");
    const std::vector<ObjectId> left_out = LeftOut(context);
    const std::uint64_t version = VersionOfShown(context, left_out);
    const ImTextureID texture = context.textures->Get("masks", version, [&] {
      const cv::Mat depth = WithoutObjects(snapshot.depth, snapshot.id, left_out);
      return MaskPicture(snapshot.image, depth, WithoutObjects(snapshot.id, snapshot.id, left_out),
                         RangeOf(depth), context.looks != nullptr ? *context.looks : ObjectLooks());
    });
    const ImageCanvas canvas(context, "masks.view", texture, context.sequence->image_width,
                             context.sequence->image_height);
    DrawPixelValue(context, canvas);
    const auto pixel = canvas.hovered();
    if (!pixel) return;
    const ObjectId object = ObjectAt(context, *pixel);
    if (object.value > 0) {
      PutTooltipBesideMouse(context);
      ImGui::SetTooltip("object #%d", object.value);
    }
    if (canvas.clicked()) sink.Post(SelectObjectCommand{object});
  }
};

}  // namespace

std::unique_ptr<Panel> MakeMasksPanel() { return std::make_unique<MasksPanel>(); }

}  // namespace plumbline
