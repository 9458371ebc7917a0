// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/outline_lines.h"

#include <gtest/gtest.h>

#include "engine/mapping/viewpoint_scorer.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

double LinesOf(TriangleMesh mesh) {
  CadModel model;
  model.name = "thing";
  model.mesh = std::move(mesh);
  const std::shared_ptr<const ModelDatabase> database = ModelDatabase::FromModels({model});
  Result<std::shared_ptr<const ViewpointModel>> views =
      ViewpointModel::Build(database->models().front(), ViewpointModelOptions{}, {});
  if (!views.ok()) return 0;
  return OutlineLines(ViewpointScorer({*views}, database), *database, ModelId{0});
}

// A block's silhouette is about the box around it. A row of thin posts has two lines for each.
TEST(OutlineLines, AreManyWhereAThingIsMadeOfMany) {
  EXPECT_NEAR(LinesOf(MakeBox({-0.5f, -0.5f, 0}, {0.5f, 0.5f, 1})), 1, 0.1);
  TriangleMesh posts;
  for (int i = 0; i < 4; ++i) {
    const float x = i % 2 == 0 ? -0.5f : 0.46f, y = i < 2 ? -0.5f : 0.46f;
    Append(MakeBox({x, y, 0}, {x + 0.04f, y + 0.04f, 1}), posts);
  }
  // Eight lines of 1 m, as seen from above a little shorter, and the box is about 1.2 m wide.
  EXPECT_NEAR(LinesOf(posts), 8.0 / (2 * 2.4), 0.35);
}

}  // namespace
}  // namespace plumbline
