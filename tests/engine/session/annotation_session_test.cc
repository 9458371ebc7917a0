// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/random_vector.h"
#include "tests/engine/session/annotation_session_fixture.h"

#include <cstdlib>
#include <fstream>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"
#include "engine/geometry/gravity.h"
#include "engine/models/mesh_file.h"

namespace plumbline {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(AnnotationSessionTest, OpensAScanWithItsModelsAndMakesAProjectBesideIt) {
  const auto session = Open();
  const AnnotationSnapshot snapshot = session->Snapshot();
  EXPECT_EQ(snapshot.project_name, "scan.annotation.json");
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "scan.annotation.json"));
  ASSERT_NE(snapshot.scan, nullptr);
  EXPECT_TRUE(snapshot.ready_to_align);
  EXPECT_EQ(snapshot.models->size(), 5u);
  EXPECT_FALSE(snapshot.Model(0)->thumbnail.empty());
  EXPECT_FALSE(snapshot.modified);
  EXPECT_FALSE(snapshot.gravity_known);
}

TEST_F(AnnotationSessionTest, FindsTheFloorFromAPointAndLevelsTheScan) {
  const auto session = Open();
  Do(*session, FindFloorCommand{scene_.scan_from_armchair * Eigen::Vector3d(0.6, 0, 0)});
  AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.floor.has_value()) << snapshot.answer;
  EXPECT_NEAR(snapshot.floor->turn_rad, 20 * std::numbers::pi / 180, 1e-4);
  EXPECT_FALSE(snapshot.floor->inliers->empty());
  EXPECT_FALSE(snapshot.floor_known) << "only once it is accepted";
  Do(*session, AcceptProposalCommand{});
  snapshot = session->Snapshot();
  EXPECT_TRUE(snapshot.floor_known);
  const Eigen::Isometry3d level = snapshot.level_from_scan * ScanFromLevel();
  EXPECT_NEAR((level * Eigen::Vector3d(1, 1, 0)).z(), 0, 1e-4);
  EXPECT_NEAR(level.linear()(2, 2), 1, 1e-8);
  Do(*session, UndoCommand{});
  EXPECT_FALSE(session->Snapshot().floor_known);
}

TEST_F(AnnotationSessionTest, TakesGravityThatIsTyped) {
  const auto session = Open();
  Do(*session, TypeGravityCommand{3 * scene_.up_in_scan, std::nullopt});
  ASSERT_TRUE(session->Snapshot().floor.has_value());
  Do(*session, AcceptProposalCommand{});
  EXPECT_LT((session->project().document().gravity_in_scan + scene_.up_in_scan).norm(), 1e-12);
  Do(*session, TypeGravityCommand{{0, 0, 0}, std::nullopt});
  EXPECT_TRUE(session->Snapshot().refused);
}

TEST_F(AnnotationSessionTest, PlacesAModelUprightOnTheFloorTheRightWayRound) {
  const auto session = WithArmchair();
  const AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_EQ(snapshot.instances.size(), 1u);
  const AnnotatedInstance& chair = snapshot.instances[0];
  EXPECT_EQ(chair.id, "armchair_0");
  EXPECT_EQ(snapshot.selected, "armchair_0");
  EXPECT_EQ(chair.annotator, "Ada");
  EXPECT_GT(chair.seconds_spent, 0);
  EXPECT_THAT(chair.scan_from_object, IsometryNear(scene_.scan_from_armchair, 0.1, 0.001));
  const auto& document = session->project().document();
  EXPECT_LT(UprightFrame(document.gravity_in_scan).Tilt(chair.scan_from_object.linear()), 1e-9);
  EXPECT_NEAR((snapshot.level_from_scan * chair.scan_from_object).translation().z(), 0, 1e-12);
}

TEST_F(AnnotationSessionTest, ALowHalfThatWasNotScannedDoesNotKeepAModelFromStanding) {
  ForgetArmchair(0.55);  // only the upper back was seen
  const auto session = Open();
  const auto height = [&] {
    const auto placement = session->Snapshot().placement;
    EXPECT_TRUE(placement && !placement->candidates.empty());
    return (scene_.scan_from_armchair.inverse() * placement->candidates[0].scan_from_object)
        .translation()
        .z();
  };
  const Eigen::Vector3d clicked = scene_.scan_from_armchair * Eigen::Vector3d(0.05, 0.08, 0);
  Do(*session, TypeGravityCommand{scene_.up_in_scan, std::nullopt});
  Do(*session, AcceptProposalCommand{});
  Do(*session, PlaceModelCommand{"armchair", clicked});
  EXPECT_NEAR(height(), 0, 0.015) << "the scan shows what it stands on";
  Do(*session, FindFloorCommand{scene_.scan_from_armchair * Eigen::Vector3d(0.9, 0.3, 0)});
  Do(*session, AcceptProposalCommand{});
  Do(*session, PlaceModelCommand{"armchair", clicked});
  EXPECT_NEAR(height(), 0, 1e-4) << "exactly on the floor";
}

TEST_F(AnnotationSessionTest, TheImagesFindWhatTheScanDoesNotHold) {
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_);
  ForgetArmchair(2);
  const auto session = Open();
  Do(*session, FindFloorCommand{scene_.scan_from_armchair * Eigen::Vector3d(0.9, 0.3, 0)});
  Do(*session, AcceptProposalCommand{});
  Do(*session,
     PlaceModelCommand{"armchair", scene_.scan_from_armchair * Eigen::Vector3d(0.08, -0.06, 0)});
  const AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.placement && !snapshot.placement->candidates.empty());
  EXPECT_TRUE(snapshot.placement->by_images);
  EXPECT_FALSE(snapshot.placement->searching);
  const PlacementCandidate& first = snapshot.placement->candidates[0];
  EXPECT_TRUE(first.from_images);
  EXPECT_GT(first.agreement.value_or(0), 0.5);
  EXPECT_FALSE(first.picture.empty());
  EXPECT_THAT(first.scan_from_object, IsometryNear(scene_.scan_from_armchair, 0.5, 0.01));
}

TEST_F(AnnotationSessionTest, OffersCandidatesWithPicturesBestFirst) {
  const auto session = Open();
  Do(*session, TypeGravityCommand{scene_.up_in_scan, std::nullopt});
  Do(*session, AcceptProposalCommand{});
  Do(*session, PlaceModelCommand{"armchair", scene_.scan_from_armchair.translation()});
  const AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.placement.has_value());
  EXPECT_FALSE(snapshot.placement->running);
  ASSERT_GT(snapshot.placement->candidates.size(), 1u);
  for (const PlacementCandidate& candidate : snapshot.placement->candidates) {
    EXPECT_LE(candidate.fitness, snapshot.placement->candidates[0].fitness + 1e-9);
    EXPECT_FALSE(candidate.picture.empty());
  }
  EXPECT_TRUE(snapshot.instances.empty());
  Do(*session, CancelProposalCommand{});
  EXPECT_FALSE(session->Snapshot().placement.has_value());
  EXPECT_TRUE(session->Snapshot().instances.empty());
}

TEST_F(AnnotationSessionTest, ACandidateIsTakenByItsId) {
  const auto session = Open();
  Do(*session, TypeGravityCommand{scene_.up_in_scan, std::nullopt});
  Do(*session, AcceptProposalCommand{});
  session->Apply(PlaceModelCommand{"armchair", scene_.scan_from_armchair.translation()}, 7);
  RunJobs(*session);
  const PlacementView placement = session->Snapshot().placement.value();
  EXPECT_EQ(placement.asked_by, 7u);
  ASSERT_GT(placement.candidates.size(), 1u);
  Do(*session, AcceptProposalCommand{99});
  EXPECT_TRUE(session->Snapshot().refused);
  EXPECT_TRUE(session->Snapshot().instances.empty());
  Do(*session, AcceptProposalCommand{placement.candidates[1].id});
  EXPECT_EQ(session->Snapshot().instances.at(0).scan_from_object.matrix(),
            placement.candidates[1].scan_from_object.matrix());
}

TEST_F(AnnotationSessionTest, PlacesWhereThereIsNoScanAndSaysSo) {
  const auto session = Open();
  Do(*session, PlaceModelCommand{"table", ScanFromLevel() * Eigen::Vector3d(30, 0, 0)});
  const AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.placement.has_value());
  EXPECT_THAT(snapshot.placement->problem, HasSubstr("points of the scan"));
  ASSERT_EQ(snapshot.placement->candidates.size(), 1u);
}

TEST_F(AnnotationSessionTest, DropsWhatAStoppedSearchFinds) {
  const auto session = Open();
  session->Apply(PlaceModelCommand{"armchair", scene_.scan_from_armchair.translation()});
  auto job = session->TakeJob();
  ASSERT_TRUE(job.has_value());
  EXPECT_TRUE(job->can_cancel);
  session->TakeCancel();
  session->Apply(CancelProposalCommand{});
  EXPECT_TRUE(session->TakeCancel());
  job->run({}, [](const auto&) {})(*session);
  EXPECT_FALSE(session->Snapshot().placement.has_value());
}

TEST_F(AnnotationSessionTest, RefinesFromWhereItIsAndSaysWhatChanged) {
  const auto session = WithArmchair();
  const Eigen::Isometry3d good = session->Snapshot().instances[0].scan_from_object;
  Eigen::Isometry3d off = good;
  off.linear() = Eigen::AngleAxisd(0.06, scene_.up_in_scan) * off.linear();
  off.translation() += ScanFromLevel().linear() * Eigen::Vector3d(0.03, -0.02, 0);
  Do(*session, SetInstancePoseCommand{"armchair_0", off});
  Do(*session, RefineInstanceCommand{"armchair_0"});
  const AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.refinement.has_value());
  const RefinementView& refinement = *snapshot.refinement;
  EXPECT_FALSE(refinement.running);
  EXPECT_THAT(refinement.scan_from_object, IsometryNear(good, 0.1, 0.001));
  EXPECT_NEAR(refinement.azimuth_rad, -0.06, 0.002);
  EXPECT_NEAR(refinement.horizontal_m, std::hypot(0.03, 0.02), 0.001);
  EXPECT_NEAR(refinement.height_m, 0, 1e-9);
  EXPECT_LT(refinement.rmse_m, refinement.before.rmse_m);
  EXPECT_GT(refinement.iteration, 5) << "told step by step";
  ASSERT_NE(refinement.residuals_m, nullptr);
  EXPECT_EQ(refinement.residuals_m->size(), snapshot.Model(1)->mesh->vertices.size());
  EXPECT_THAT(snapshot.instances[0].scan_from_object, IsometryNear(off, 1e-9, 1e-12))
      << "nothing changes before it is accepted";
  Do(*session, AcceptProposalCommand{});
  EXPECT_THAT(session->Snapshot().instances[0].scan_from_object, IsometryNear(good, 0.1, 0.001));
  Do(*session, UndoCommand{});
  EXPECT_EQ(session->Snapshot().instances[0].scan_from_object.matrix(), off.matrix());
}

TEST_F(AnnotationSessionTest, EveryEditCanBeUndoneAndRedone) {
  const auto session = WithArmchair();
  const auto document = DocumentToJsonText(session->project());
  ChangeInstanceCommand change;
  change.id = "armchair_0";
  change.set.id = "the chair";
  change.set.note = "wobbles";
  change.set.fine = false;
  Do(*session, change);
  EXPECT_EQ(session->Snapshot().selected, "the chair");
  Do(*session, DuplicateInstanceCommand{"the chair"});
  EXPECT_EQ(session->Snapshot().selected, "armchair_0");
  Do(*session, RemoveInstanceCommand{"the chair"});
  EXPECT_EQ(session->Snapshot().instances.size(), 1u);
  const auto changed = DocumentToJsonText(session->project());
  for (int i = 0; i < 3; ++i) Do(*session, UndoCommand{});
  EXPECT_EQ(DocumentToJsonText(session->project()), document);
  for (int i = 0; i < 3; ++i) Do(*session, RedoCommand{});
  EXPECT_EQ(DocumentToJsonText(session->project()), changed);
}

TEST_F(AnnotationSessionTest, RefusesToMoveWhatIsLockedAndSaysWhy) {
  const auto session = WithArmchair();
  ChangeInstanceCommand lock;
  lock.id = "armchair_0";
  lock.set.locked = true;
  Do(*session, lock);
  const Eigen::Isometry3d before = session->Snapshot().instances[0].scan_from_object;
  Do(*session, SetInstancePoseCommand{"armchair_0", Eigen::Isometry3d::Identity()});
  EXPECT_TRUE(session->Snapshot().refused);
  EXPECT_THAT(session->Snapshot().answer, HasSubstr("locked"));
  EXPECT_EQ(session->Snapshot().instances[0].scan_from_object.matrix(), before.matrix());
}

TEST_F(AnnotationSessionTest, RecoversWhatWasNotSavedAndSaysHowMuch) {
  std::string document;
  {
    const auto session = WithArmchair();
    document = DocumentToJsonText(session->project());
  }  // not saved
  const auto session = Open();
  EXPECT_EQ(DocumentToJsonText(session->project()), document);
  ASSERT_FALSE(session->Snapshot().notices.empty());
  EXPECT_THAT(session->Snapshot().notices[0], HasSubstr("2 edits recovered"));
  EXPECT_TRUE(session->Snapshot().modified);
  Do(*session, SaveProjectCommand{});
  Do(*session, DismissNoticesCommand{});
  EXPECT_FALSE(session->Snapshot().modified);
  EXPECT_THAT(session->Snapshot().notices, IsEmpty());
}

TEST_F(AnnotationSessionTest, ASecondWindowReadsOnlyUntilItSavesAs) {
  const auto first = WithArmchair();
  Do(*first, SaveProjectCommand{});
  const auto second = Open();
  EXPECT_TRUE(second->Snapshot().read_only);
  ASSERT_FALSE(second->Snapshot().notices.empty());
  EXPECT_THAT(second->Snapshot().notices[0], HasSubstr("open in another window"));
  Do(*second, RemoveInstanceCommand{"armchair_0"});
  EXPECT_TRUE(second->Snapshot().refused);
  Do(*second, SaveProjectCommand{(folder_.path() / "mine.json").string()});
  EXPECT_FALSE(second->Snapshot().read_only);
  Do(*second, RemoveInstanceCommand{"armchair_0"});
  EXPECT_TRUE(second->Snapshot().instances.empty());
}

TEST_F(AnnotationSessionTest, WritesNothingIntoAFolderThatIsMeantToStayAsItIs) {
  using std::filesystem::perms;
  const TemporaryFolder data;
  ::setenv("XDG_DATA_HOME", data.path().c_str(), 1);
  std::filesystem::permissions(folder_.path(), perms::owner_read | perms::owner_exec);
  {
    const auto session = Open();
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "scan.annotation.json"));
    ASSERT_EQ(session->Snapshot().notices.size(), 1u);
    EXPECT_THAT(session->Snapshot().notices[0], HasSubstr(data.path().string()));
    Do(*session, TypeGravityCommand{scene_.up_in_scan, std::nullopt});
    Do(*session, AcceptProposalCommand{});
    Do(*session, SaveProjectCommand{});
  }
  EXPECT_TRUE(Open()->Snapshot().gravity_known) << "found again by the scan";
  std::filesystem::permissions(folder_.path(), perms::owner_all);
  ::unsetenv("XDG_DATA_HOME");
}

TEST_F(AnnotationSessionTest, OpensAProjectByItsFile) {
  { Do(*WithArmchair(), SaveProjectCommand{}); }
  EXPECT_TRUE(IsForAnnotation(folder_.path() / "scan.annotation.json"));
  EXPECT_FALSE(IsForAnnotation(folder_.path() / "models" / "models.json"));
  const auto session = Open(folder_.path() / "scan.annotation.json");
  EXPECT_EQ(session->Snapshot().instances.size(), 1u);
  EXPECT_NE(session->Snapshot().scan, nullptr);
}

TEST_F(AnnotationSessionTest, TakesTheObjectsOfARunAsDraftsInOneStep) {
  const auto session = Open();
  std::ofstream(folder_.path() / "run.json") << R"({"objects": [
      {"id": 3, "model": "table", "category": "dining table", "confirmed": true,
       "world_from_object": [[1,0,0,1],[0,1,0,2],[0,0,1,0],[0,0,0,1]]},
      {"id": 4, "model": "chair", "category": "chair", "confirmed": true,
       "world_from_object": [[1,0,0,0],[0,1,0,2],[0,0,1,0],[0,0,0,1]]}]})";
  Do(*session, ImportDraftsCommand{(folder_.path() / "run.json").string()});
  AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_EQ(snapshot.instances.size(), 2u) << snapshot.answer;
  EXPECT_EQ(snapshot.instances[0].id, "table_0");
  EXPECT_FALSE(snapshot.instances[0].fine);
  EXPECT_THAT(snapshot.instances[0].note, HasSubstr("draft"));
  Do(*session, UndoCommand{});
  EXPECT_TRUE(session->Snapshot().instances.empty());
}

TEST_F(AnnotationSessionTest, ChecksTheSelectedObjectInImagesFromAllSidesAsItMoves) {
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_);
  const auto session = WithArmchair();
  AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.checks.has_value()) << snapshot.answer;
  ASSERT_EQ(snapshot.checks->images.size(), 9u);
  EXPECT_EQ(std::count_if(snapshot.checks->images.begin(), snapshot.checks->images.end(),
                          [](const ImageCheckView& image) { return image.held_out; }),
            3);
  EXPECT_GT(snapshot.checks->agreement, 0.8);
  const Eigen::Isometry3d placed = snapshot.instances[0].scan_from_object;
  const Eigen::Isometry3d moved = placed * Eigen::Translation3d(0.06, 0.02, 0);
  const std::uint64_t images = snapshot.images_number;
  Do(*session, PreviewPoseCommand{"armchair_0", moved});
  snapshot = session->Snapshot();
  EXPECT_LT(snapshot.checks->agreement, 0.5);
  EXPECT_EQ(snapshot.images_number, images) << "the same images";
  EXPECT_EQ(snapshot.instances[0].scan_from_object.matrix(), placed.matrix()) << "only looked at";
  Do(*session, SetInstancePoseCommand{"armchair_0", moved});
  Do(*session, RefineInstanceCommand{"armchair_0", true, RefineBy::kImages});
  snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.refinement.has_value());
  EXPECT_EQ(snapshot.refinement->problem, "");
  EXPECT_THAT(snapshot.refinement->scan_from_object,
              IsometryNear(scene_.scan_from_armchair, 0.3, 0.004));
  EXPECT_GT(snapshot.checks->agreement, 0.8) << "of what is proposed";
  EXPECT_EQ(snapshot.refinement->height_std_m, 0) << "it stays on the floor";
  EXPECT_GT(snapshot.refinement->horizontal_std_m, 0.01) << "the cameras may all be off";
  EXPECT_GT(snapshot.refinement->agreement_held_out.value(), 0.8);
  EXPECT_LT(snapshot.refinement->before.agreement_held_out.value(), 0.5);
  Do(*session, CancelProposalCommand{});
  EXPECT_LT(session->Snapshot().checks->agreement, 0.5);
}

TEST_F(AnnotationSessionTest, RefinesByScanAndImagesTogetherAndOffersEachAlone) {
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_);
  const auto session = WithArmchair();
  const Eigen::Isometry3d placed = session->Snapshot().instances[0].scan_from_object;
  const Eigen::Isometry3d moved = placed * Eigen::Translation3d(0.03, 0.02, 0);
  Do(*session, SetInstancePoseCommand{"armchair_0", moved});
  Do(*session, RefineInstanceCommand{"armchair_0"});
  AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.refinement.has_value());
  ASSERT_EQ(snapshot.refinement->found.size(), 3u) << snapshot.refinement->one_problem;
  EXPECT_EQ(snapshot.refinement->by, RefineBy::kBoth);
  EXPECT_FALSE(snapshot.refinement->contradict);
  EXPECT_THAT(snapshot.refinement->scan_from_object,
              IsometryNear(scene_.scan_from_armchair, 0.3, 0.004));
  EXPECT_GT(snapshot.refinement->fitness, snapshot.refinement->before.fitness);
  EXPECT_GT(snapshot.checks->agreement, 0.8) << "of what is proposed";
  ASSERT_EQ(snapshot.checks->images[0].others.size(), 1u) << "where it is placed, beside it";
  EXPECT_FALSE(snapshot.checks->images[0].others[0].by.has_value());
  const std::uint64_t number = snapshot.proposal_number;
  Do(*session, ChooseRefinementCommand{RefineBy::kImages});
  snapshot = session->Snapshot();
  EXPECT_EQ(snapshot.refinement->by, RefineBy::kImages);
  EXPECT_EQ(snapshot.refinement->scan_from_object.matrix(),
            snapshot.refinement->found[2].scan_from_object.matrix());
  EXPECT_NE(snapshot.proposal_number, number);
  Do(*session, AcceptProposalCommand{});
  EXPECT_EQ(session->Snapshot().instances[0].scan_from_object.matrix(),
            snapshot.refinement->scan_from_object.matrix());
}

TEST_F(AnnotationSessionTest, ShowsTheCandidateThatIsJudgedBesideWhatIsPlaced) {
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_);
  const auto session = WithArmchair();
  Do(*session, PlaceAgainCommand{"armchair_0"});
  AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.placement.has_value());
  ASSERT_FALSE(snapshot.placement->candidates.empty());
  ASSERT_TRUE(snapshot.checks.has_value());
  ASSERT_FALSE(snapshot.checks->images.empty());
  EXPECT_GT(snapshot.checks->agreement, 0.8) << "of the first candidate";
  const Eigen::Isometry3d turned =
      snapshot.instances[0].scan_from_object * Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitZ());
  Do(*session, PreviewPoseCommand{"armchair_0", turned});
  snapshot = session->Snapshot();
  EXPECT_LT(snapshot.checks->agreement, 0.5) << "of the one that is looked at";
  ASSERT_EQ(snapshot.checks->images[0].others.size(), 1u);
  EXPECT_FALSE(snapshot.checks->images[0].others[0].lines.empty());
  // A new one has no place yet, and is shown all the same.
  Do(*session, CancelProposalCommand{});
  Do(*session, RemoveInstanceCommand{"armchair_0"});
  Do(*session,
     PlaceModelCommand{"armchair", scene_.scan_from_armchair * Eigen::Vector3d(0.1, 0.08, 0.4)});
  snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.checks.has_value());
  EXPECT_EQ(snapshot.checks->instance, "");
  ASSERT_FALSE(snapshot.checks->images.empty());
  EXPECT_GT(snapshot.checks->agreement, 0.8);
  EXPECT_TRUE(snapshot.checks->images[0].others.empty());
}

TEST_F(AnnotationSessionTest, MasksAreMadeWhenTheyAreAskedForAndAreThoseOfTheExport) {
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_);
  const auto session = WithArmchair();
  Do(*session, ShowFrameCommand{7});
  EXPECT_FALSE(session->Snapshot().frame.value().image.empty());
  EXPECT_TRUE(session->Snapshot().frame->instances.empty()) << "nobody looks at them";
  Do(*session, ShowFrameCommand{7, true});
  const cv::Mat instances = session->Snapshot().frame.value().instances;
  EXPECT_EQ(session->Snapshot().frame->masks_problem, "");
  ASSERT_EQ(instances.size(), session->Snapshot().frame->image.size());
  ExportCommand command{"bop", (folder_.path() / "bop").string()};
  command.despite_findings = true;
  command.every = 7;
  Do(*session, command);
  ASSERT_EQ(session->Snapshot().exported.value().problem, "");
  const cv::Mat exported = cv::imread(
      folder_.path() / "bop/test/000000/mask_visib/000007_000000.png", cv::IMREAD_GRAYSCALE);
  ASSERT_EQ(exported.size(), instances.size());
  EXPECT_GT(cv::countNonZero(exported), 100);
  EXPECT_EQ(cv::countNonZero((exported > 0) != (instances == 1)), 0);
  // And in closed form: what it shows are pixels that the chair's bounding sphere covers.
  const auto sequence = OpenSequence(sequence_).value();
  const Eigen::Vector3d middle = session->Snapshot().instances[0].scan_from_object *
                                 session->Snapshot().models->front().bounds.center().cast<double>();
  const auto pixel = SeenAt(*sequence, 7, Eigen::Isometry3d::Identity(), middle);
  const cv::Moments moments = cv::moments(exported, true);
  EXPECT_NEAR(moments.m10 / moments.m00, pixel.value().x(), 0.1 * exported.cols);
  EXPECT_NEAR(moments.m01 / moments.m00, pixel.value().y(), 0.1 * exported.cols);
}

TEST_F(AnnotationSessionTest, RegistersASequenceOfAnotherFrameByPairsAndUndoesIt) {
  const Eigen::Isometry3d world_from_scan =
      Eigen::Translation3d(2, -1, 0.5) *
      Eigen::AngleAxisd(2.2, Eigen::Vector3d(0.1, -0.3, 1).normalized());
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_, world_from_scan);
  const auto session = Open();
  Do(*session, TypeGravityCommand{scene_.up_in_scan, std::nullopt});
  Do(*session, AcceptProposalCommand{});
  Do(*session, AlignSequenceCommand{AlignSequenceCommand::How::kPairs, ""});
  EXPECT_THAT(session->Snapshot().sequence_alignment->problem, HasSubstr("two pairs"));
  Do(*session, ShowFrameCommand{7});
  ASSERT_TRUE(session->Snapshot().frame.has_value());
  EXPECT_EQ(session->Snapshot().frame->frame, 7);
  EXPECT_FALSE(session->Snapshot().frame->image.empty());
  const auto sequence = OpenSequence(sequence_).value();
  const Eigen::Vector3d corners[] = {{0.3, 0.2, 0.4}, {-0.3, 0.3, 0.1}, {0.2, -0.4, 0.6}};
  for (const auto& [frame, corner] : {std::pair{2, 0}, {2, 1}, {9, 2}, {16, 0}}) {
    const Eigen::Vector3d in_scan = scene_.scan_from_armchair * corners[corner];
    const auto pixel = SeenAt(*sequence, frame, world_from_scan.inverse(), in_scan);
    Do(*session, AddPairCommand{in_scan, frame, pixel.value()});
  }
  EXPECT_GT(session->Snapshot().pairs[0].residual_px, 10) << "not registered";
  Do(*session, AlignSequenceCommand{AlignSequenceCommand::How::kPairs, ""});
  AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.sequence_alignment.has_value());
  EXPECT_EQ(snapshot.sequence_alignment->problem, "");
  EXPECT_LT(snapshot.pairs[0].residual_px, 0.1) << "by what is proposed";
  EXPECT_FALSE(snapshot.sequence_registered);
  Do(*session, AcceptProposalCommand{});
  const auto& document = session->project().document();
  ASSERT_TRUE(document.scan_from_world.has_value());
  EXPECT_THAT(*document.scan_from_world, IsometryNear(world_from_scan.inverse(), 0.01, 1e-4));
  Do(*session, UndoCommand{});
  EXPECT_FALSE(document.scan_from_world.has_value());
  Do(*session, RedoCommand{});
  EXPECT_TRUE(document.scan_from_world.has_value());
}

TEST_F(AnnotationSessionTest, RegistersASequenceByThePointsOfItsMap) {
  const Eigen::Isometry3d world_from_scan =
      Eigen::Translation3d(2, -1, 0.5) *
      Eigen::AngleAxisd(2.2, Eigen::Vector3d(0.1, -0.3, 1).normalized());
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_, world_from_scan);
  const auto session = Open();
  Do(*session, TypeGravityCommand{scene_.up_in_scan, std::nullopt});
  Do(*session, AcceptProposalCommand{});
  const std::filesystem::path file = folder_.path() / "map.ply";
  Do(*session, AlignSequenceCommand{AlignSequenceCommand::How::kPoints, file.string()});
  EXPECT_THAT(session->Snapshot().sequence_alignment->problem, HasSubstr("map.ply"));
  // Sparse and noisy, as a filter maps them.
  const TriangleMesh scan = ReadMesh(scene_.scan).value();
  Random random({3, 0});
  TriangleMesh map;
  for (std::size_t i = 0; i < scan.vertices.size(); i += 37) {
    const Eigen::Vector3d noise = GaussianVector<3>(random);
    map.vertices.push_back(
        (world_from_scan * (scan.vertices[i].cast<double>() + 0.005 * noise)).cast<float>());
  }
  ASSERT_TRUE(WritePly(file, map).ok());
  Do(*session, AlignSequenceCommand{AlignSequenceCommand::How::kPoints, file.string()});
  const auto proposed = session->Snapshot().sequence_alignment;
  ASSERT_TRUE(proposed.has_value());
  EXPECT_EQ(proposed->problem, "");
  Do(*session, AcceptProposalCommand{});
  EXPECT_THAT(session->project().document().scan_from_world.value(),
              IsometryNear(world_from_scan.inverse(), 0.3, 0.01));
}

TEST_F(AnnotationSessionTest, RegistersASequenceByTheObjectsOfARunAndSaysHowFarEachIsOff) {
  const Eigen::Isometry3d world_from_scan =
      Eigen::Translation3d(2, -1, 0.5) *
      Eigen::AngleAxisd(2.2, Eigen::Vector3d(0.1, -0.3, 1).normalized());
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_, world_from_scan);
  const auto session = WithArmchair();
  Do(*session, PlaceModelCommand{"table", scene_.scan_from_table * Eigen::Vector3d(0, 0, 0.7)});
  Do(*session, AcceptProposalCommand{});
  nlohmann::json objects = nlohmann::json::array();
  for (const auto& instance : session->project().document().instances) {
    const Eigen::Matrix4d pose = (world_from_scan * instance.scan_from_object).matrix();
    nlohmann::json rows;
    for (int row = 0; row < 4; ++row) {
      rows.push_back({pose(row, 0), pose(row, 1), pose(row, 2), pose(row, 3)});
    }
    objects.push_back({{"id", 1 + objects.size()},
                       {"model", instance.model},
                       {"category", instance.category},
                       {"confirmed", true},
                       {"world_from_object", rows}});
  }
  std::ofstream(folder_.path() / "run.json") << nlohmann::json{{"objects", objects}};
  Do(*session, AlignSequenceCommand{AlignSequenceCommand::How::kObjects,
                                    (folder_.path() / "run.json").string()});
  const auto proposed = session->Snapshot().sequence_alignment;
  ASSERT_TRUE(proposed.has_value());
  EXPECT_EQ(proposed->problem, "");
  ASSERT_EQ(proposed->residuals.size(), 2u);
  EXPECT_EQ(proposed->residuals[1].name, "table 2");
  EXPECT_LT(proposed->residuals[1].meters, 1e-3);
  Do(*session, AcceptProposalCommand{});
  EXPECT_THAT(session->project().document().scan_from_world.value(),
              IsometryNear(world_from_scan.inverse(), 0.1, 1e-3));
}

}  // namespace
}  // namespace plumbline
