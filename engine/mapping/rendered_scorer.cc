// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/rendered_scorer.h"

#include "engine/base/check.h"

namespace plumbline {

Result<std::unique_ptr<RenderedScorer>> RenderedScorer::Create(
    std::shared_ptr<const ModelDatabase> database, const AtlasOptions& options) {
  std::unique_ptr<RenderedScorer> scorer(new RenderedScorer);
  Result<std::unique_ptr<RenderContext>> context = RenderContext::CreateHeadless();
  if (!context.ok()) return context.error();
  scorer->context_ = std::move(context).value();
  Result<std::unique_ptr<HypothesisAtlas>> atlas =
      HypothesisAtlas::Create(*scorer->context_, options);
  if (!atlas.ok()) return atlas.error();
  scorer->atlas_ = std::move(atlas).value();
  for (const CadModel& model : database->models())
    scorer->mesh_of_model_.push_back(scorer->atlas_->AddMesh(model.mesh));
  scorer->database_ = std::move(database);
  return scorer;
}

void RenderedScorer::Score(const ScoringView& view, const UprightFrame& upright,
                           std::span<const PoseHypothesis> hypotheses,
                           std::span<HypothesisScore> scores) const {
  PLB_CHECK(scores.size() == hypotheses.size());
  PLB_CHECK(view.table != nullptr && view.table->width() == view.camera.width &&
            view.table->height() == view.camera.height);
  PLB_CHECK(view.outline_offsets_px == (std::array<double, 4>{}))
      << "the reference has outlines where they are";
  static_assert(OrientedTable::kBins == 16);
  AtlasView image;
  image.camera = view.camera;
  const std::vector<std::uint8_t> hits = view.table->Interleaved();
  image.hits = hits;
  image.chance = view.table->chance();
  image.occluder_depth = view.occluder_depth;
  image.occlusion_margin_m = view.occlusion_margin_m;
  image.near_m = view.near_m;
  std::vector<AtlasHypothesis> placed;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
    world_from_object.linear() = upright.WorldFromObjectRotation(hypothesis.azimuth_rad);
    world_from_object.translation() =
        hypothesis.center_in_world -
        world_from_object.linear() *
            (hypothesis.scale() * database_->model(hypothesis.label).center());
    placed.push_back({mesh_of_model_[static_cast<std::size_t>(hypothesis.label.value)],
                      view.cam_from_world * world_from_object, hypothesis.scale()});
  }
  std::vector<AtlasScore> found(hypotheses.size());
  atlas_->Score(image, placed, found);
  for (std::size_t i = 0; i < found.size(); ++i) {
    scores[i] = {found[i].agreement_m, found[i].visible_m, found[i].total_m, found[i].whole_box,
                 found[i].visible_box};
  }
}

}  // namespace plumbline
