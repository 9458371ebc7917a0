// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "engine/mapping/hypothesis_scorer.h"
#include "engine/models/model_database.h"
#include "engine/render/hypothesis_atlas.h"

namespace plumbline {

/// The reference scorer: every hypothesis is rendered and its contour found in the picture, in GLSL
/// (HypothesisAtlas). Its context is its own and headless; use and destroy it in the thread that
/// made it.
class RenderedScorer : public HypothesisScorer {
 public:
  /// Errors: kUnsupported without OpenGL 4.3.
  static Result<std::unique_ptr<RenderedScorer>> Create(
      std::shared_ptr<const ModelDatabase> database, const AtlasOptions& options);
  void Score(const ScoringView& view, const UprightFrame& upright,
             std::span<const PoseHypothesis> hypotheses,
             std::span<HypothesisScore> scores) const override;
  /// GL_RENDERER and GL_VERSION.
  std::string Description() const { return context_->Description(); }

 private:
  RenderedScorer() = default;
  std::shared_ptr<const ModelDatabase> database_;
  std::unique_ptr<RenderContext> context_;
  std::unique_ptr<HypothesisAtlas> atlas_;
  std::vector<int> mesh_of_model_;
};

}  // namespace plumbline
