// SPDX-License-Identifier: Apache-2.0
// What the session writes: crops and their models, pairs, exports; and what it does where it
// cannot.

#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <fstream>

#include "engine/base/files.h"
#include "engine/dataset/ground_truth.h"
#include "engine/geometry/gravity.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_move.h"
#include "engine/snapshot/export_formats.h"
#include "tests/engine/session/annotation_session_fixture.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

using std::filesystem::exists;
using testing::HasSubstr;

/// The scan is a surface: a box, finely meshed, that stands on the floor, instead of points.
class CutInWindow : public AnnotationSessionTest {
 protected:
  void SetUp() override {
    TriangleMesh level = MakeGrid({-1.5f, -1.5f, 0}, {3, 0, 0}, {0, 3, 0}, 120);
    Append(Transformed(MakeFineBox({0.6f, 0.4f, 0.8f}), level_from_box_), level);
    ASSERT_TRUE(WritePly(scene_.scan, Transformed(level, ScanFromLevel())).ok());
  }
  /// A little larger than what is to be cut out, as the window's box is after a click.
  UprightBox Around(double height_m = 1.0) const {
    const Eigen::Isometry3d scan_from_box = ScanFromLevel() * level_from_box_;
    return {scan_from_box * Eigen::Vector3d(0, 0, 0.5 * height_m - 0.05),
            {0.8, 0.6, height_m},
            UprightFrame(-scene_.up_in_scan).Azimuth(scan_from_box.linear())};
  }
  std::unique_ptr<AnnotationSession> OnFloor() {
    auto session = Open();
    Do(*session, FindFloorCommand{ScanFromLevel() * Eigen::Vector3d(-1, -1, 0)});
    Do(*session, AcceptProposalCommand{});
    return session;
  }
  static ProposeCropCommand Cut(const UprightBox& box) {
    ProposeCropCommand command{"chest", "suitcase"};
    command.box = box;
    return command;
  }

  Eigen::Isometry3d level_from_box_ =
      Eigen::Translation3d(0.3, 0.2, 0) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ());
};

TEST_F(CutInWindow, TheBoxTellsWhatItHoldsAndHowFarItCanShrink) {
  const auto session = OnFloor();
  Do(*session, ShowBoxCommand{Around()});
  const auto box = session->Snapshot().box;
  ASSERT_TRUE(box.has_value());
  EXPECT_GT(box->points->size(), 1000u);
  ASSERT_FALSE(box->bounds.isEmpty());
  EXPECT_NEAR(box->bounds.sizes().x(), 0.6, 0.01);
  EXPECT_NEAR(box->bounds.sizes().y(), 0.4, 0.01);
  EXPECT_NEAR(box->bounds.max().z(), 0.8 - 0.45, 0.01) << "from the middle of the box";
  Do(*session, ShowBoxCommand{Around(0.4)});
  EXPECT_LT(session->Snapshot().box->points->size(), box->points->size());
  Do(*session, ShowBoxCommand{});
  EXPECT_FALSE(session->Snapshot().box.has_value());
}

TEST_F(CutInWindow, ABoxIsFittedToWhatWasClicked) {
  const auto session = OnFloor();
  const Eigen::Vector3d on_top = level_from_box_ * Eigen::Vector3d(0.1, -0.05, 0.8);
  const double azimuth_rad =
      UprightFrame(-scene_.up_in_scan).Azimuth((ScanFromLevel() * level_from_box_).linear());
  Do(*session, FitBoxCommand{ScanFromLevel() * on_top, azimuth_rad + 0.3});
  const auto fitted = session->Snapshot().fitted_box;
  ASSERT_NE(fitted, nullptr);
  ASSERT_TRUE(fitted->box.has_value()) << session->Snapshot().answer;
  EXPECT_NEAR(fitted->box->size_m.x(), 0.6, 0.06);
  EXPECT_NEAR(fitted->box->size_m.y(), 0.4, 0.06);
  EXPECT_NEAR(fitted->box->size_m.z(), 0.8, 0.04);
  EXPECT_NEAR(std::abs(WrapAngle(fitted->box->azimuth_rad - azimuth_rad)), 0, 0.05);
  const Eigen::Vector3d center = ScanFromLevel().inverse() * fitted->box->center_in_scan;
  EXPECT_LT((center - level_from_box_ * Eigen::Vector3d(0, 0, 0.4)).norm(), 0.03);
  Do(*session, FitBoxCommand{ScanFromLevel() * Eigen::Vector3d(-1, -1, 0), 0});
  ASSERT_NE(session->Snapshot().fitted_box, fitted);
  EXPECT_FALSE(session->Snapshot().fitted_box->box.has_value()) << "the floor is no thing";
}

TEST_F(CutInWindow, TheModelOfACutGoesWithUndoAndComesBackWithRedo) {
  const auto session = OnFloor();
  const std::size_t before = session->Snapshot().models->size();
  Do(*session, Cut(Around()));
  ASSERT_TRUE(session->Snapshot().crop.has_value());
  ASSERT_EQ(session->Snapshot().crop->problem, "");
  EXPECT_FALSE(HasModel(scene_.models, "chest")) << "only proposed";
  Do(*session, AcceptProposalCommand{});
  EXPECT_TRUE(HasModel(scene_.models, "chest"));
  EXPECT_EQ(session->Snapshot().models->size(), before + 1);
  EXPECT_EQ(session->Snapshot().selected, "chest_0");
  EXPECT_THAT(session->Snapshot().instances[0].scan_from_object,
              IsometryNear(ScanFromLevel() * level_from_box_, 0.5, 0.005));
  Do(*session, UndoCommand{});
  EXPECT_FALSE(HasModel(scene_.models, "chest"));
  EXPECT_FALSE(exists(scene_.models / "chest.ply")) << "no orphan beside the other models";
  EXPECT_EQ(session->Snapshot().models->size(), before);
  Do(*session, RedoCommand{});
  EXPECT_TRUE(HasModel(scene_.models, "chest"));
  EXPECT_EQ(session->Snapshot().models->size(), before + 1);
}

TEST_F(AnnotationSessionTest, PairsAreEditsThatAreUndoneAndSurviveTheEndOfTheProcess) {
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_);
  {
    const auto session = Open();
    Do(*session, AddPairCommand{{0.1, 0.2, 0.3}, 4, {100, 50}});
    Do(*session, AddPairCommand{{0.4, 0.2, 0.3}, 5, {200, 60}});
    EXPECT_EQ(session->Snapshot().undo_label, "Pick a pair in frame 5");
    Do(*session, UndoCommand{});
    EXPECT_EQ(session->Snapshot().pairs.size(), 1u);
    Do(*session, RedoCommand{});
    Do(*session, RemovePairCommand{0});
    ASSERT_EQ(session->Snapshot().pairs.size(), 1u);
    EXPECT_EQ(session->Snapshot().pairs[0].frame, 5);
    Do(*session, UndoCommand{});
    EXPECT_EQ(session->Snapshot().pairs[0].frame, 4) << "in its place";
  }  // not saved
  const auto session = Open();
  ASSERT_EQ(session->Snapshot().pairs.size(), 2u);
  EXPECT_EQ(session->Snapshot().pairs[1].pixel, Eigen::Vector2d(200, 60));
  EXPECT_TRUE(session->Snapshot().pairs[0].seen_at.has_value());
}

TEST_F(AnnotationSessionTest, WritesEveryFormatInTheFrameThatIsChosen) {
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_);
  const auto session = Open();
  const std::string out = (folder_.path() / "out").string();
  Do(*session, ExportCommand{"ground_truth", out + ".json"});
  EXPECT_THAT(session->Snapshot().exported->problem, HasSubstr("nothing to export"));
  Do(*session, FindFloorCommand{scene_.scan_from_armchair * Eigen::Vector3d(0.5, 0.5, 0)});
  Do(*session, AcceptProposalCommand{});
  Do(*session, PlaceModelCommand{"armchair", scene_.scan_from_armchair.translation()});
  Do(*session, AcceptProposalCommand{});
  for (const ExportFormat& format : kExportFormats) {
    Do(*session, ExportCommand{format.name, out + "/" + format.name + "/" + format.file,
                               format.level ? "level" : "scan", 8});
    ASSERT_TRUE(session->Snapshot().exported.has_value());
    EXPECT_EQ(session->Snapshot().exported->problem, "") << format.name;
    EXPECT_TRUE(exists(out + "/" + format.name)) << format.name;
  }
  const auto level = ReadGroundTruth(out + "/ground_truth/ground_truth.json");
  ASSERT_TRUE(level.ok()) << level.error().message;
  const Eigen::Isometry3d level_from_scan = session->Snapshot().level_from_scan;
  EXPECT_THAT(level->instances[0].world_from_object,
              IsometryNear(level_from_scan * session->Snapshot().instances[0].scan_from_object,
                           1e-9, 1e-12));
  EXPECT_NEAR(level->instances[0].world_from_object.translation().z(), 0, 1e-9) << "on the floor";
  EXPECT_TRUE(exists(out + "/visma/visma/fragments/augmented_scene.ply"));
  // The whole of VISMA's folder is in one frame.
  const auto alignment = ReadJson(out + "/visma/visma/fragments/alignment.json");
  ASSERT_TRUE(alignment.ok());
  EXPECT_NEAR((*alignment)["armchair_0"][11].get<double>(), 0, 1e-9);
  const auto fragment = ReadMesh(out + "/visma/visma/fragments/armchair_0.ply");
  ASSERT_TRUE(fragment.ok()) << fragment.error().message;
  EXPECT_NEAR(BoundingBox(*fragment).min().z(), 0, 0.01);
  Do(*session, ExportCommand{"visma", out + "/visma2", "world"});
  EXPECT_THAT(session->Snapshot().exported->problem, HasSubstr("not in that of the sequence"));
}

TEST_F(AnnotationSessionTest, OnAFullDiskItSaysSoGoesOnAndSavesElsewhere) {
  const auto session = WithArmchair();
  rlimit old;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  rlimit full = old;
  full.rlim_cur =
      std::filesystem::file_size(scene_.scan.parent_path() / "scan.annotation.json.journal") + 20;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
  Do(*session, DuplicateInstanceCommand{"armchair_0"});
  const std::string problem = session->Snapshot().journal_problem;
  const std::size_t count = session->Snapshot().instances.size();
  Do(*session, SaveProjectCommand{});
  const bool refused = session->Snapshot().refused;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
  signal(SIGXFSZ, handler);
  EXPECT_THAT(problem, HasSubstr("save it elsewhere"));
  EXPECT_EQ(count, 2u) << "the work goes on in memory";
  EXPECT_TRUE(refused);
  const auto elsewhere = folder_.path() / "elsewhere" / "mine.json";
  std::filesystem::create_directories(elsewhere.parent_path());
  Do(*session, SaveProjectCommand{elsewhere.string()});
  EXPECT_EQ(session->Snapshot().journal_problem, "");
  const auto saved = AnnotationProject::Open(elsewhere, AnnotationProject::Access::kRead);
  ASSERT_TRUE(saved.ok()) << saved.error().message;
  EXPECT_EQ((*saved)->document().instances.size(), 2u);
}

TEST_F(AnnotationSessionTest, WhatWasRecoveredCanBeTakenBackAtOnce) {
  { const auto session = WithArmchair(); }  // not saved
  const auto session = Open();
  EXPECT_EQ(session->Snapshot().num_recovered, 2u);
  Do(*session, DropRecoveredCommand{});
  EXPECT_TRUE(session->Snapshot().instances.empty());
  EXPECT_FALSE(session->Snapshot().floor_known);
  EXPECT_EQ(session->Snapshot().num_recovered, 0u);
  Do(*session, RedoCommand{});
  Do(*session, RedoCommand{});
  EXPECT_EQ(session->Snapshot().instances.size(), 1u);
}

TEST_F(AnnotationSessionTest, SeveralObjectsAreChangedAndRemovedInOneStep) {
  const auto session = WithArmchair();
  Do(*session, DuplicateInstanceCommand{"armchair_0"});
  ChangeInstanceCommand hide{"armchair_0", {}, {"armchair_1"}};
  hide.set.hidden = true;
  Do(*session, hide);
  EXPECT_TRUE(session->Snapshot().instances[0].hidden && session->Snapshot().instances[1].hidden);
  Do(*session, UndoCommand{});
  EXPECT_FALSE(session->Snapshot().instances[0].hidden || session->Snapshot().instances[1].hidden);
  const auto place = [&](int i) {
    return session->Snapshot().instances[static_cast<std::size_t>(i)].scan_from_object;
  };
  const Eigen::Isometry3d first = place(0), second = place(1);
  const Eigen::Isometry3d by(Eigen::Translation3d(0.1, 0.2, 0));
  Do(*session, SetInstancePoseCommand{"armchair_0", by * first, {{"armchair_1", by * second}}});
  EXPECT_TRUE(place(0).isApprox(by * first) && place(1).isApprox(by * second));
  EXPECT_EQ(session->Snapshot().undo_label, "Move 2 objects");
  Do(*session, UndoCommand{});
  EXPECT_TRUE(place(0).isApprox(first) && place(1).isApprox(second));
  Do(*session, DuplicateInstanceCommand{"armchair_0", {"armchair_1"}});
  ASSERT_EQ(session->Snapshot().instances.size(), 4u);
  EXPECT_EQ(session->Snapshot().selected, "armchair_2");
  EXPECT_GT((place(2).translation() - place(3).translation()).norm(), 0.3)
      << "the copies do not stand in each other";
  Do(*session, UndoCommand{});
  ASSERT_EQ(session->Snapshot().instances.size(), 2u);
  Do(*session, RemoveInstanceCommand{"armchair_1", {"armchair_0"}});
  EXPECT_TRUE(session->Snapshot().instances.empty());
  EXPECT_EQ(session->Snapshot().selected, "");
  Do(*session, UndoCommand{});
  EXPECT_EQ(session->Snapshot().instances.size(), 2u);
}

TEST_F(AnnotationSessionTest, ListsWhatIsWrongAfterEveryEdit) {
  const auto session = WithArmchair();
  EXPECT_EQ(session->Snapshot().checklist.NumErrors(), 0);
  Eigen::Isometry3d lifted = session->Snapshot().instances[0].scan_from_object;
  lifted.translation() += 0.05 * scene_.up_in_scan;
  Do(*session, SetInstancePoseCommand{"armchair_0", lifted});
  const ChecklistView list = session->Snapshot().checklist;
  ASSERT_EQ(list.NumErrors(), 1);
  EXPECT_EQ(list.findings[0].kind, "floating");
  EXPECT_EQ(list.findings[0].instances, std::vector<std::string>{"armchair_0"});
  Do(*session, UndoCommand{});
  EXPECT_TRUE(session->Snapshot().checklist.findings.empty());
}

TEST_F(AnnotationSessionTest, NothingIsExportedWithOpenErrorsWithoutAWord) {
  const auto session = WithArmchair();
  Eigen::Isometry3d lifted = session->Snapshot().instances[0].scan_from_object;
  lifted.translation() += 0.05 * scene_.up_in_scan;
  Do(*session, SetInstancePoseCommand{"armchair_0", lifted});
  ExportCommand command{"ground_truth", (folder_.path() / "ground_truth.json").string()};
  Do(*session, command);
  ASSERT_EQ(session->Snapshot().exported.value().open_findings.size(), 1u);
  EXPECT_THAT(session->Snapshot().exported->open_findings[0], HasSubstr("floats"));
  EXPECT_FALSE(std::filesystem::exists(command.out));
  command.despite_findings = true;
  Do(*session, command);
  EXPECT_TRUE(session->Snapshot().exported->open_findings.empty());
  EXPECT_TRUE(std::filesystem::exists(command.out));
}

TEST_F(AnnotationSessionTest, WhatIsAllRightIsNotOpenUntilItMoves) {
  const auto session = WithArmchair();
  Eigen::Isometry3d lifted = session->Snapshot().instances[0].scan_from_object;
  lifted.translation() += 0.05 * scene_.up_in_scan;
  Do(*session, SetInstancePoseCommand{"armchair_0", lifted});
  ASSERT_TRUE(session->Snapshot().checklist.findings[0].can_accept);
  const auto open = [&] { return session->Snapshot().checklist.NumErrors(); };
  Do(*session, AcceptFindingCommand{"floating", {"armchair_0"}, true, "stands on a box"});
  EXPECT_EQ(open(), 0);
  const ChecklistView list = session->Snapshot().checklist;
  ASSERT_EQ(list.NumAccepted(), 1);
  EXPECT_EQ(list.findings[0].accepted_by, "Ada");
  EXPECT_EQ(list.findings[0].accepted_note, "stands on a box");
  EXPECT_EQ(session->Snapshot().undo_label, "Accept that armchair_0 is floating");
  const ExportCommand command{"ground_truth", (folder_.path() / "ground_truth.json").string()};
  Do(*session, command);
  EXPECT_TRUE(session->Snapshot().exported.value().open_findings.empty());
  EXPECT_THAT(session->Snapshot().exported->done, HasSubstr("1 finding was accepted"));

  Do(*session, UndoCommand{});
  EXPECT_EQ(open(), 1);
  Do(*session, RedoCommand{});
  EXPECT_EQ(open(), 0);
  ChangeInstanceCommand rename{"armchair_0", {}, {}};
  rename.set.id = "my chair";
  Do(*session, rename);
  EXPECT_EQ(open(), 0) << "it is still the same object";
  Eigen::Isometry3d moved = lifted;
  moved.translation() += 0.005 * scene_.up_in_scan.unitOrthogonal();
  Do(*session, SetInstancePoseCommand{"my chair", moved});
  EXPECT_EQ(open(), 0) << "that is a little";
  moved.translation() += 0.01 * scene_.up_in_scan.unitOrthogonal();
  Do(*session, SetInstancePoseCommand{"my chair", moved});
  EXPECT_EQ(open(), 1) << "it was said of somewhere else";
  Do(*session, UndoCommand{});
  EXPECT_EQ(open(), 0);
  Do(*session, AcceptFindingCommand{"floating", {"my chair"}, false});
  EXPECT_EQ(open(), 1);
  Do(*session, AcceptFindingCommand{"tilted", {"my chair"}});
  EXPECT_TRUE(session->Snapshot().refused) << "it is not";
}

TEST_F(AnnotationSessionTest, RefineFindsAScaleThatIsUnlockedAndEverythingRespectsIt) {
  const auto session = WithArmchair();
  const Eigen::Isometry3d placed = session->Snapshot().instances[0].scan_from_object;
  ChangeInstanceCommand wrong{"armchair_0", {}, {}};
  wrong.set.scale = 1.03;
  Do(*session, wrong);
  EXPECT_EQ(session->Snapshot().undo_label, "Scale armchair_0");
  Do(*session, RefineInstanceCommand{"armchair_0"});
  EXPECT_EQ(session->Snapshot().refinement.value().scale_std, 0) << "it is locked";
  Do(*session, CancelProposalCommand{});
  ChangeInstanceCommand unlock{"armchair_0", {}, {}};
  unlock.set.may_scale = true;
  Do(*session, unlock);
  Do(*session, RefineInstanceCommand{"armchair_0"});
  const RefinementView refinement = session->Snapshot().refinement.value();
  EXPECT_EQ(refinement.problem, "");
  EXPECT_EQ(refinement.scale_problem, "");
  EXPECT_NEAR(refinement.scale, 1, 0.01);
  EXPECT_GT(refinement.scale_std, 0);
  Do(*session, AcceptProposalCommand{});
  EXPECT_EQ(session->Snapshot().instances[0].scale, refinement.scale);
  EXPECT_LT((session->Snapshot().instances[0].scan_from_object.translation() - placed.translation())
                .norm(),
            0.02);

  Do(*session, wrong);
  const std::filesystem::path truth = folder_.path() / "truth.json", visma = folder_.path() / "v";
  ExportCommand command{"ground_truth", truth.string()};
  command.despite_findings = true;
  Do(*session, command);
  EXPECT_EQ(ReadGroundTruth(truth).value().instances[0].scale, 1.03);
  command.format = "visma";
  command.out = visma.string();
  Do(*session, command);
  EXPECT_THAT(session->Snapshot().exported->done, HasSubstr("1 scaled objects have models"));
  const auto bounds = [&](const std::filesystem::path& file) {
    return BoundingBox(ReadMesh(file).value()).sizes().norm();
  };
  EXPECT_NEAR(bounds(visma / "CAD" / "armchair_x1.0300.obj"),
              1.03f * session->Snapshot().models->front().bounds.sizes().norm(), 0.02f);

  wrong.set.scale = 20.0;
  Do(*session, wrong);
  EXPECT_TRUE(session->Snapshot().refused);
}

TEST_F(AnnotationSessionTest, IsComparedWithWhatAnotherAnnotatorPlacedAfterEveryEdit) {
  const auto session = WithArmchair();
  const Eigen::Isometry3d placed = session->Snapshot().instances[0].scan_from_object;
  GroundTruth other;
  other.gravity_in_world = -scene_.up_in_scan;
  const Eigen::Vector3d across = scene_.up_in_scan.unitOrthogonal();
  other.instances.push_back(
      {"grace_0", "armchair", "chair",
       Eigen::Translation3d(0.03 * across - 0.01 * scene_.up_in_scan) * placed, true});
  other.instances.push_back({"grace_1", "table", "dining table",
                             Eigen::Translation3d(2 * across) * scene_.scan_from_table, true});
  const std::filesystem::path file = folder_.path() / "grace.truth.json";
  ASSERT_TRUE(WriteGroundTruth(file, other).ok());
  Do(*session, CompareWithCommand{file.string()});
  const AgreementView agreement = session->Snapshot().agreement.value();
  EXPECT_EQ(agreement.name, "grace.truth.json");
  EXPECT_EQ(agreement.problem, "");
  EXPECT_FALSE(agreement.running);
  ASSERT_EQ(agreement.rows.size(), 2u);
  EXPECT_EQ(agreement.rows[0].first, "armchair_0");
  EXPECT_EQ(agreement.rows[0].second, "grace_0");
  EXPECT_NEAR(agreement.rows[0].horizontal_m, 0.03, 1e-6);
  EXPECT_NEAR(agreement.rows[0].height_m, 0.01, 1e-6) << "ours is higher";
  EXPECT_NEAR(agreement.rows[0].azimuth_rad.value(), 0, 1e-6);
  EXPECT_EQ(agreement.rows[1].first, "") << "only there";
  EXPECT_EQ(agreement.rows[1].second, "grace_1");
  EXPECT_EQ(agreement.pooled, 0) << "too few to tell";

  Do(*session, SetInstancePoseCommand{"armchair_0", Eigen::Translation3d(0.01 * across) * placed});
  EXPECT_NEAR(session->Snapshot().agreement->rows[0].horizontal_m, 0.02, 1e-6);
  Do(*session, CompareWithCommand{(folder_.path() / "nothing.json").string()});
  EXPECT_NE(session->Snapshot().agreement->problem, "");
  Do(*session, CompareWithCommand{});
  EXPECT_FALSE(session->Snapshot().agreement.has_value());
}

TEST_F(AnnotationSessionTest, ComparesAllObjectsWithTheirImagesWhenAsked) {
  sequence_ = folder_.path() / "walk";
  WriteAnnotationWalk(scene_, sequence_);
  const auto session = WithArmchair();
  Do(*session, CompareAllCommand{});
  EXPECT_EQ(session->Snapshot().checklist.compared, 1);
  EXPECT_FALSE(session->Snapshot().checklist.comparing);
  EXPECT_TRUE(session->Snapshot().checklist.findings.empty());
  Eigen::Isometry3d turned = session->Snapshot().instances[0].scan_from_object;
  turned.linear() = Eigen::AngleAxisd(0.8, scene_.up_in_scan) * turned.linear();
  turned.translation() += 0.4 * scene_.up_in_scan.unitOrthogonal();
  Do(*session, SetInstancePoseCommand{"armchair_0", turned});
  Do(*session, CompareAllCommand{});
  const ChecklistView list = session->Snapshot().checklist;
  ASSERT_EQ(list.NumErrors(), 1);
  EXPECT_EQ(list.findings[0].kind, "low_agreement");
  Do(*session, UndoCommand{});
  EXPECT_TRUE(session->Snapshot().checklist.findings.empty()) << "it is elsewhere again";
}

TEST_F(AnnotationSessionTest, AnExportAsksBeforeItReplacesSomethingElseAndKeepsIt) {
  const auto session = WithArmchair();
  const std::filesystem::path out = folder_.path() / "ground_truth.json";
  const auto exported = [&] { return session->Snapshot().exported.value(); };
  const auto files = [&] {
    std::string names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      const std::string name = entry.path().filename().string();
      if (name.find("ground_truth") != std::string::npos) names += name + " ";
    }
    return names;
  };
  Do(*session, ExportCommand{"ground_truth", out.string()});
  EXPECT_FALSE(exported().asks) << "there was nothing";
  const std::string first = *ReadFile(out);
  Do(*session, ExportCommand{"ground_truth", out.string()});
  EXPECT_FALSE(exported().asks) << "it is the same";
  Eigen::Isometry3d moved = session->Snapshot().instances[0].scan_from_object;
  moved.translation() += Eigen::Vector3d(0.03, 0, 0);
  Do(*session, SetInstancePoseCommand{"armchair_0", moved});
  Do(*session, DuplicateInstanceCommand{"armchair_0"});
  Do(*session, ExportCommand{"ground_truth", out.string()});
  ASSERT_TRUE(exported().asks);
  ASSERT_EQ(exported().differences.size(), 2u);
  EXPECT_EQ(exported().differences[0],
            "1 object would be moved: armchair_0 by 3.0 cm and 0.0\u00b0.");
  EXPECT_EQ(exported().differences[1], "1 object would be new: armchair_1.");
  EXPECT_EQ(*ReadFile(out), first) << "nothing is replaced before the answer";
  Do(*session, AnswerExportCommand{false});
  EXPECT_EQ(*ReadFile(out), first);
  EXPECT_EQ(files(), "ground_truth.json ") << "nothing is left behind";
  Do(*session, AnswerExportCommand{true});
  EXPECT_EQ(*ReadFile(out), first) << "there is no question any more";
  Do(*session, ExportCommand{"ground_truth", out.string()});
  Do(*session, AnswerExportCommand{true});
  EXPECT_THAT(exported().done, HasSubstr("ground_truth.json.bak"));
  EXPECT_EQ(*ReadFile(out.string() + ".bak"), first);
  EXPECT_EQ(ReadGroundTruth(out).value().instances.size(), 2u);
  Do(*session, RemoveInstanceCommand{"armchair_1"});
  Do(*session, ExportCommand{"ground_truth", out.string()});
  EXPECT_EQ(exported().differences[0], "1 object would be gone: armchair_1.");
  Do(*session, AnswerExportCommand{true});
  EXPECT_EQ(*ReadFile(out.string() + ".bak"), first) << "each has a name of its own";
  EXPECT_TRUE(exists(out.string() + ".bak-2"));
  std::ofstream(out) << "notes of mine";
  Do(*session, ExportCommand{"ground_truth", out.string()});
  EXPECT_THAT(exported().differences[0], HasSubstr("no ground truth that can be read"));
}

TEST_F(AnnotationSessionTest, AnExportIntoAFolderAsksAboutTheFilesThatItWouldReplace) {
  const auto session = WithArmchair();
  const std::filesystem::path out = folder_.path() / "visma";
  Do(*session, ExportCommand{"visma", out.string()});
  EXPECT_FALSE(session->Snapshot().exported->asks);
  std::ofstream(out / "fragments/objects.json") << "mine";
  std::ofstream(out / "readme") << "mine";
  Do(*session, ExportCommand{"visma", out.string()});
  ASSERT_TRUE(session->Snapshot().exported->asks);
  EXPECT_EQ(session->Snapshot().exported->differences[0],
            "1 file would be replaced: fragments/objects.json.");
  Do(*session, AnswerExportCommand{true});
  EXPECT_EQ(*ReadFile(out.string() + ".bak/fragments/objects.json"), "mine");
  EXPECT_EQ(*ReadFile(out / "readme"), "mine");
  EXPECT_NE(*ReadFile(out / "fragments/objects.json"), "mine");
  std::ofstream(folder_.path() / "file") << "mine";
  Do(*session, ExportCommand{"visma", (folder_.path() / "file").string()});
  EXPECT_THAT(session->Snapshot().exported->problem, HasSubstr("needs a folder"));
}

TEST_F(AnnotationSessionTest, AtItsEndItSavesSoThatOnlyACrashLeavesSomethingToRecover) {
  {
    const auto session = WithArmchair();
    session->Close();
  }
  const auto session = Open();
  EXPECT_EQ(session->Snapshot().num_recovered, 0u);
  EXPECT_FALSE(session->Snapshot().modified);
  EXPECT_TRUE(session->Snapshot().notices.empty());
  ASSERT_EQ(session->Snapshot().instances.size(), 1u);
  Do(*session, UndoCommand{});
  EXPECT_TRUE(session->Snapshot().instances.empty()) << "undo goes on where it was";
}

TEST_F(AnnotationSessionTest, AScanInMillimetresIsAskedAboutAndACopyInMetresIsAnEdit) {
  const TriangleMesh scan = ReadMesh(scene_.scan).value();
  ASSERT_TRUE(WritePly(scene_.scan, Scaled(scan, 1000)).ok());
  const auto session = Open();
  ASSERT_TRUE(session->Snapshot().doubted_size_m.has_value());
  EXPECT_GT(*session->Snapshot().doubted_size_m, 1000);
  Do(*session, SetScanUnitCommand{0.001});
  EXPECT_FALSE(session->Snapshot().doubted_size_m.has_value());
  EXPECT_EQ(session->Snapshot().scan_name, "scan-metres.ply");
  EXPECT_TRUE(session->Snapshot().ready_to_align);
  EXPECT_LT(BoundingBox(*session->Snapshot().scan).sizes().maxCoeff(), 10);
  Do(*session, UndoCommand{});
  EXPECT_EQ(session->Snapshot().scan_name, "scan.ply");
  EXPECT_TRUE(session->Snapshot().doubted_size_m.has_value());
  Do(*session, SetScanUnitCommand{1});
  EXPECT_FALSE(session->Snapshot().doubted_size_m.has_value()) << "it is as it should be";
  Do(*session, RedoCommand{});
  EXPECT_EQ(session->Snapshot().scan_name, "scan-metres.ply");
  // In metres, the armchair is found.
  Do(*session, FindFloorCommand{scene_.scan_from_armchair * Eigen::Vector3d(0.5, 0.5, 0)});
  Do(*session, AcceptProposalCommand{});
  Do(*session, PlaceModelCommand{"armchair", scene_.scan_from_armchair.translation()});
  Do(*session, AcceptProposalCommand{});
  EXPECT_THAT(session->Snapshot().instances[0].scan_from_object,
              IsometryNear(scene_.scan_from_armchair, 0.3, 0.005));
}

TEST_F(AnnotationSessionTest, PointsThatAreNoneAreLeftOutAndCounted) {
  TriangleMesh scan = ReadMesh(scene_.scan).value();
  const std::size_t count = scan.vertices.size();
  for (const std::size_t i : {3u, 70u, 71u}) scan.vertices[i].setConstant(NAN);
  ASSERT_TRUE(WritePly(scene_.scan, scan).ok());
  const auto session = Open();
  EXPECT_EQ(session->Snapshot().scan_points, count - 3);
  ASSERT_EQ(session->Snapshot().notices.size(), 1u);
  EXPECT_THAT(session->Snapshot().notices[0],
              HasSubstr("3 of " + std::to_string(count) + " points of scan.ply are not finite"));
}

}  // namespace
}  // namespace plumbline
