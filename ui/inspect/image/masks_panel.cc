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
    // Both versions only grow.
    const std::uint64_t version = context.snapshot_version + context.looks_version;
    const ImTextureID texture = context.textures->Get("masks", version, [&] {
      return MaskPicture(snapshot.image, snapshot.depth, snapshot.id, RangeOf(snapshot.depth),
                         context.looks != nullptr ? *context.looks : ObjectLooks());
    });
    const ImageCanvas canvas(context, "masks.view", texture, context.sequence->image_width,
                             context.sequence->image_height);
    DrawPixelValue(context, canvas);
    const auto pixel = canvas.hovered();
    if (!pixel) return;
    const ObjectId object = ObjectAt(context, *pixel);
    if (object.value > 0) ImGui::SetTooltip("object #%d", object.value);
    if (canvas.clicked()) sink.Post(SelectObjectCommand{object});
  }
};

}  // namespace

std::unique_ptr<Panel> MakeMasksPanel() { return std::make_unique<MasksPanel>(); }

}  // namespace plumbline
