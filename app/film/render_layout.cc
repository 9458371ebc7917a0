// SPDX-License-Identifier: Apache-2.0
#include "app/film/render_layout.h"

namespace plumbline {

const std::vector<RenderLayout>& RenderLayouts() {
  static const std::vector<RenderLayout> kLayouts = {
      {"inspect", "the whole window", {}},
      {"image", "the image with proposals and mean outlines", {{"image", 0, 0, 1, 1}}},
      {"map", "the map in 3-D", {{"scene", 0, 0, 1, 1}}},
      {"through",
       "the models over the image, through the camera, beside the map",
       {{"image", 0, 0, 0.5f, 1}, {"scene", 0.5f, 0, 1, 1}}},
      {"insets",
       "the image with mean outlines, with edges, Z-buffer and masks beside it",
       {{"image", 0, 0, 0.72f, 1},
        {"edges", 0.72f, 0, 1, 0.333f},
        {"depth", 0.72f, 0.333f, 1, 0.667f},
        {"masks", 0.72f, 0.667f, 1, 1}}},
      {"column",
       "boxes, edges and masks in a column, the map with scan and path beside it",
       {{"image", 0, 0, 0.32f, 0.333f},
        {"edges", 0, 0.333f, 0.32f, 0.667f},
        {"masks", 0, 0.667f, 0.32f, 1},
        {"scene", 0.32f, 0, 1, 1}}},
      {"truth",
       "estimates in green on the truth in grey",
       {{"scene", 0, 0, 1, 1}},
       {{"scene",
         {{"color", "on truth"},
          {"scan", false},
          {"particles", false},
          {"names", false},
          {"frustum", false}}}}},
      {"flow",
       "the two pathways with milliseconds on each node, over image, edges and map",
       {{"flow", 0, 0, 1, 0.36f},
        {"image", 0, 0.36f, 0.36f, 1},
        {"edges", 0.36f, 0.36f, 0.64f, 1},
        {"scene", 0.64f, 0.36f, 1, 1}}}};
  return kLayouts;
}

Result<const RenderLayout*> FindRenderLayout(const std::string& name) {
  std::string names;
  for (const RenderLayout& layout : RenderLayouts()) {
    if (name == layout.name) return &layout;
    names += (names.empty() ? "" : ", ") + std::string(layout.name);
  }
  return Error{ErrorCode::kNotFound, "there is no layout '" + name + "'; choose one of " + names};
}

}  // namespace plumbline
