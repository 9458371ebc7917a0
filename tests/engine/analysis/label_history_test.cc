// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/label_history.h"

#include <gtest/gtest.h>

#include "engine/mapping/particle_rank.h"

namespace plumbline {
namespace {

TEST(LabelHistory, KeepsEveryShapeThatEverHadMoreThanFivePercent) {
  RunHistory history;
  const std::vector<std::vector<LabelProbability>> beliefs = {
      {{{4}, 0.5}, {{7}, 0.5}},
      {},
      {{{4}, 0.93}, {{7}, 0.04}, {{2}, 0.03}},
      {{{9}, 0.06}, {{4}, 0.94}}};
  for (std::size_t i = 0; i < beliefs.size(); ++i) {
    auto frame = std::make_shared<FrameSample>();
    frame->frame = 10 * static_cast<int>(i);
    frame->objects.resize(2);
    frame->objects[0].id = {8};
    frame->objects[0].label_probability = {{{5}, 1.0}};
    frame->objects[1].id = {3};
    frame->objects[1].label_probability = beliefs[i];
    history.frames.push_back(i == 1 ? nullptr : frame);  // one is not read yet
  }
  const LabelHistory labels = LabelsOf(history, {3});
  EXPECT_EQ(labels.labels, (std::vector<ModelId>{{4}, {7}, {9}})) << "shape 2 never had 5 %";
  ASSERT_EQ(labels.frames.size(), 3u);
  EXPECT_EQ(labels.frames[1].frame, 20);
  EXPECT_EQ(labels.frames[1].probability, (std::vector<float>{0.93f, 0.04f, 0}));
  EXPECT_EQ(labels.frames[2].probability, (std::vector<float>{0.94f, 0, 0.06f}));
  EXPECT_TRUE(LabelsOf(history, {1}).labels.empty());
}

TEST(ParticleRank, IsByWeightAndThenByScore) {
  std::vector<Particle> particles(4);
  particles[0].log_weight = -1;
  particles[1].log_weight = -0.5f;
  particles[2].log_weight = -1;
  particles[2].phi_edge = 0.2f;
  particles[3].log_weight = -1;
  particles[3].phi_cnn = 0.1f;
  EXPECT_EQ(ByRank(particles, 2, 8), (std::vector<int>{2, 1, 3, 0}));
  EXPECT_EQ(ByRank(particles, 0, 0), (std::vector<int>{1, 0, 2, 3}));
}

}  // namespace
}  // namespace plumbline
