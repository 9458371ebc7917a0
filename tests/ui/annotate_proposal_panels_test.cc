// SPDX-License-Identifier: Apache-2.0
// Panels of the Annotate workspace that propose something, without a display.

#include "ui/annotate/annotate_panels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/ui/annotate_harness.h"

namespace plumbline {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(AnnotateImagesPanel, SaysHowMuchLiesOnEdgesAndLooksFromThere) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_images");
  harness.size = {700, 200};
  harness.snapshot().checks = MadeUpChecks();
  harness.snapshot().images_number = 1;
  EXPECT_THAT(harness.Text(*panel), HasSubstr("42 % of the outline on edges"));
  EXPECT_EQ(harness.textures.pictures_made, 2);
  harness.Click(*panel, "images.1");
  ASSERT_TRUE(harness.view.look_from.has_value());
  EXPECT_EQ(*harness.view.look_from, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(harness.sink.commands.empty());
}

TEST(AnnotateFloorPanel, FindsPicksAndTypes) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_floor");
  harness.snapshot().floor_known = false;
  EXPECT_THAT(harness.Text(*panel), HasSubstr("where is it?"));
  harness.Click(*panel, "floor.find");
  ASSERT_NE(harness.sink.Last<FindFloorCommand>(), nullptr);
  EXPECT_FALSE(harness.sink.Last<FindFloorCommand>()->seed_in_scan.has_value());
  harness.Click(*panel, "floor.pick");
  EXPECT_EQ(harness.view.tool, AnnotateTool::kFloor);
  harness.Click(*panel, "floor.typed", 0.1f);
  harness.Type(*panel, "floor.height", "0.5");
  harness.Click(*panel, "floor.type");
  const auto* typed = harness.sink.Last<TypeGravityCommand>();
  ASSERT_NE(typed, nullptr);
  EXPECT_EQ(typed->up_in_scan, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(typed->floor_offset_m, -0.5) << "up . x + offset = 0 at that height";
  harness.snapshot().ready_to_align = false;
  harness.sink.commands.clear();
  harness.Click(*panel, "floor.find");
  EXPECT_TRUE(harness.sink.commands.empty()) << "not before the scan is prepared";
}

TEST(AnnotateFloorPanel, ShowsAProposalWithItsNumbersAndTakesIt) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_floor");
  harness.snapshot().floor = MadeUpFloor();
  const std::string text = harness.Text(*panel);
  EXPECT_THAT(text, HasSubstr("picked"));
  EXPECT_THAT(text, HasSubstr("at 0.250 m along up"));
  EXPECT_THAT(text, HasSubstr("4321"));
  harness.view.tool = AnnotateTool::kFloor;
  harness.Click(*panel, "proposal.accept");
  EXPECT_NE(harness.sink.Last<AcceptProposalCommand>(), nullptr);
  EXPECT_EQ(harness.view.tool, AnnotateTool::kSelect);
  EXPECT_TRUE(harness.view.reset);
  harness.Click(*panel, "proposal.cancel");
  EXPECT_NE(harness.sink.Last<CancelProposalCommand>(), nullptr);
}

TEST(AnnotateCandidatesPanel, TakesTheCandidateThatIsChosenByItsId) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_candidates");
  harness.snapshot().placement = MadeUpPlacement();
  auto& candidates = harness.snapshot().placement->candidates;
  std::swap(candidates[0], candidates[1]);  // the images preferred the second
  EXPECT_THAT(harness.Text(*panel), HasSubstr("2 found in 0.25 s."));
  harness.Click(*panel, "candidate.1");
  EXPECT_EQ(harness.view.candidate, 1);
  harness.Click(*panel, "proposal.accept");
  ASSERT_NE(harness.sink.Last<AcceptProposalCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<AcceptProposalCommand>()->candidate, 0);
  harness.snapshot().placement->problem = "there are only 3 points";
  EXPECT_THAT(harness.Text(*panel),
              HasSubstr("there are only 3 points. It can be placed as it is"));
}

TEST(AnnotateRefinementPanel, SaysWhatMovedAndBetweenWhat) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_refinement");
  harness.snapshot().refinement = MadeUpRefinement();
  std::string text = harness.Text(*panel);
  for (const char* part : {"armchair_0", "converged", "+5.73", "20.0 mm", "kept", "80 %",
                           "was 50 %", "3.0 mm rms", "was 9.0"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_THAT(text, Not(HasSubstr("Tilt")));
  harness.snapshot().refinement->tilt_rad = 0.0175;
  EXPECT_THAT(harness.Text(*panel), HasSubstr("1.00\u00b0"));
  RefinementView& refinement = *harness.snapshot().refinement;
  refinement.has_images = true;
  refinement.has_scan = false;
  refinement.agreement_held_out = 0.61;
  refinement.before.agreement_held_out = 0.33;
  text = harness.Text(*panel);
  EXPECT_THAT(text, HasSubstr("On edges"));
  EXPECT_THAT(text, HasSubstr("61 %"));
  EXPECT_THAT(text, HasSubstr("was 33 %"));
  EXPECT_THAT(text, Not(HasSubstr("mm rms")));
  harness.Click(*panel, "proposal.accept");
  EXPECT_NE(harness.sink.Last<AcceptProposalCommand>(), nullptr);
  harness.Click(*panel, "proposal.cancel");
  EXPECT_NE(harness.sink.Last<CancelProposalCommand>(), nullptr);
}

TEST(AnnotateCropPanel, ProposesTheBoxAndTakesWhatIsReady) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_crop");
  harness.view.tool = AnnotateTool::kCut;
  EXPECT_THAT(harness.Text(*panel), HasSubstr("Click the object in the scan"));
  EXPECT_EQ(harness.widgets.Find("crop.cut"), nullptr) << "there is nothing to cut yet";
  harness.view.crop_box = LevelBox{{1, -1, 0.5}, {0.7, 0.7, 1}, 0};
  harness.Type(*panel, "crop.name", "stool");
  harness.Type(*panel, "crop.size_z", "2", keys::kTab);
  EXPECT_NEAR(harness.view.crop_box->center.z(), 1, 1e-9) << "its bottom stays";
  harness.Click(*panel, "crop.fragment");
  harness.Click(*panel, "crop.cut");
  const auto* crop = harness.sink.Last<ProposeCropCommand>();
  ASSERT_NE(crop, nullptr);
  EXPECT_EQ(crop->id, "stool");
  EXPECT_TRUE(crop->fragment);
  EXPECT_EQ(crop->box.value().size_m.z(), 2);
  harness.snapshot().crop = CropView{"stool"};
  harness.Click(*panel, "proposal.accept");
  EXPECT_EQ(harness.sink.Last<AcceptProposalCommand>(), nullptr) << "it is still being cut";
  harness.snapshot().crop = MadeUpCrop();
  EXPECT_THAT(harness.Text(*panel), HasSubstr("0.40 x 0.50 x 0.60 m"));
  harness.Click(*panel, "proposal.accept");
  EXPECT_NE(harness.sink.Last<AcceptProposalCommand>(), nullptr);
  EXPECT_EQ(harness.view.tool, AnnotateTool::kSelect);
}

TEST(AnnotateSequencePanel, RegistersByWhatThereIs) {
  using How = AlignSequenceCommand::How;
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_sequence");
  harness.Click(*panel, "sequence.by_pairs");
  EXPECT_TRUE(harness.sink.commands.empty()) << "without pairs";
  harness.snapshot().pairs.resize(3);
  harness.snapshot().pairs[0].seen_at = Eigen::Vector2d(1, 2);
  harness.snapshot().pairs[0].residual_px = 3.25;
  const std::string text = harness.Text(*panel);
  EXPECT_THAT(text, HasSubstr("3.2 px"));
  EXPECT_THAT(text, HasSubstr("not seen"));
  harness.Click(*panel, "sequence.remove.1");
  EXPECT_EQ(harness.sink.Last<RemovePairCommand>()->index, 1u);
  harness.Click(*panel, "sequence.by_pairs");
  EXPECT_EQ(harness.sink.Last<AlignSequenceCommand>()->how, How::kPairs);
  harness.Type(*panel, "sequence.objects.field", "walk.plb");
  EXPECT_EQ(harness.sink.Last<AlignSequenceCommand>()->how, How::kObjects);
  EXPECT_EQ(harness.sink.Last<AlignSequenceCommand>()->file, "walk.plb");
}

TEST(AnnotateSequencePanel, ShowsAProposalWithItsResiduals) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_sequence");
  harness.snapshot().sequence_alignment = MadeUpAlignment();
  std::string text = harness.Text(*panel);
  for (const char* part : {"By objects", "12.3 cm", "table 2", "1.5 cm", "none near"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  harness.snapshot().sequence_alignment->problem = "no pair fits";
  text = harness.Text(*panel);
  EXPECT_THAT(text, HasSubstr("no pair fits"));
  harness.Click(*panel, "proposal.accept");
  EXPECT_EQ(harness.sink.Last<AcceptProposalCommand>(), nullptr);
}

TEST(AnnotateFramePanel, AsksForItsFirstFrameOnce) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_frame");
  harness.Draw(*panel, 5);
  ASSERT_EQ(harness.sink.commands.size(), 1u);
  EXPECT_EQ(harness.sink.Last<ShowFrameCommand>()->frame, 20);
}

TEST(AnnotateFramePanel, AClickCompletesAPairThatBeganInTheScan) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_frame");
  harness.size = {700, 400};
  harness.snapshot().frame = FrameView{7, cv::Mat(90, 160, CV_8UC3, cv::Scalar(60, 60, 60)), ""};
  harness.Click(*panel, "frame.view");
  EXPECT_EQ(harness.sink.Last<AddPairCommand>(), nullptr);
  ASSERT_TRUE(harness.view.pick_pixel.has_value()) << "half a pair";
  harness.view.pick_pixel.reset();
  harness.view.pick_in_scan = Eigen::Vector3d(1, 2, 3);
  harness.Click(*panel, "frame.view");
  const auto* pair = harness.sink.Last<AddPairCommand>();
  ASSERT_NE(pair, nullptr);
  EXPECT_EQ(pair->in_scan, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(pair->frame, 7);
  EXPECT_NEAR(pair->pixel.x(), 80, 1);
  EXPECT_FALSE(harness.view.pick_in_scan.has_value());
}

TEST(AnnotateRefinementPanel, OffersEachAloneAndSaysByHowMuchTheyDisagree) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_refinement");
  RefinementView refinement = MadeUpRefinement();
  for (const RefineBy by : {RefineBy::kBoth, RefineBy::kScan, RefineBy::kImages}) {
    RefinedPose found;
    found.by = by;
    found.horizontal_m = by == RefineBy::kImages ? 0.042 : 0.003;
    found.agreement_held_out = 0.57;
    refinement.found.push_back(found);
  }
  refinement.apart.horizontal_m = 0.039;
  refinement.apart.horizontal_std_m = 0.012;
  refinement.contradict = true;
  harness.snapshot().refinement = refinement;
  const std::string text = harness.Text(*panel);
  for (const char* part : {"Together", "By scan", "By images", "42 mm", "other images 57 %",
                           "39 mm", "12 mm", "contradict each other"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  harness.Click(*panel, "refined.images");
  EXPECT_EQ(harness.sink.Last<ChooseRefinementCommand>()->by, RefineBy::kImages);
}

}  // namespace
}  // namespace plumbline
