// SPDX-License-Identifier: Apache-2.0
// What the session knows of the work itself: time spent, how far it is, the queue; and where copies
// land.

#include <numbers>

#include "engine/base/files.h"
#include "engine/geometry/gravity.h"
#include "engine/session/annotation_queue.h"
#include "engine/session/place_beside.h"
#include "tests/engine/session/annotation_session_fixture.h"

namespace plumbline {
namespace {

/// A clock that goes on only when it is told, and the two objects of the scene.
class TimeSpent : public AnnotationSessionTest {
 protected:
  void SetUp() override {
    tick_s_ = 0;
    session_ = Open();
    After(5, FindFloorCommand{scene_.scan_from_armchair * Eigen::Vector3d(0.5, 0.5, 0)});
    After(5, AcceptProposalCommand{});
  }
  void After(double seconds, const AnnotationCommand& command) {
    seconds_ += seconds;
    Do(*session_, command);
  }
  /// Somebody works on: input every so often.
  void WorkFor(double seconds, bool placing = false) {
    for (; seconds > 0; seconds -= 2) After(std::min(seconds, 2.0), ActivityCommand{placing});
  }
  void Place(const char* model, const Eigen::Isometry3d& pose) {
    After(0, PlaceModelCommand{model, pose * Eigen::Vector3d(0.1, 0.08, 0.4)});
    After(3, AcceptProposalCommand{});
  }
  double SavedSpent(const std::string& id) const {
    const AnnotatedInstance* instance = session_->project().document().Find(id);
    return instance == nullptr ? -1 : instance->seconds_spent;
  }
  double ShownSpent(const std::string& id) const {
    return session_->Snapshot().Find(id)->seconds_spent;
  }
  void Nudge(const std::string& id) {
    Eigen::Isometry3d pose = session_->Snapshot().Find(id)->scan_from_object;
    pose.translation().x() += 0.001;
    After(0, SetInstancePoseCommand{id, pose});
  }

  std::unique_ptr<AnnotationSession> session_;
};

TEST_F(TimeSpent, AfterTheLastEditIsKeptAtTheEndOfASitting) {
  Place("armchair", scene_.scan_from_armchair);
  const double before = SavedSpent("armchair_0");
  WorkFor(2);
  session_->Close();
  EXPECT_DOUBLE_EQ(SavedSpent("armchair_0"), before) << "a glance";
  WorkFor(8);
  session_->Close();
  EXPECT_DOUBLE_EQ(SavedSpent("armchair_0"), before + 10);
  EXPECT_FALSE(session_->project().modified()) << "and saved";
}

TEST_F(TimeSpent, ADoneProjectThatIsEditedIsInWorkAgain) {
  Place("armchair", scene_.scan_from_armchair);
  After(0, SetStageCommand{WorkStage::kDone, ""});
  ASSERT_EQ(session_->Snapshot().stage, WorkStage::kDone);
  ChangeInstanceCommand hide{"armchair_0", {}, {}};
  hide.set.hidden = true;
  After(0, hide);
  EXPECT_EQ(session_->Snapshot().stage, WorkStage::kDone) << "nothing of what was done changed";
  Nudge("armchair_0");
  EXPECT_EQ(session_->Snapshot().stage, WorkStage::kInWork);
  EXPECT_EQ(session_->Snapshot().project_state.value().annotator, "Ada");
  EXPECT_EQ(session_->Snapshot().project_state->note, "edited after it was done");
  EXPECT_EQ(session_->Snapshot().answer, "The project was done, and is in work again.");
  After(0, UndoCommand{});
  EXPECT_EQ(session_->Snapshot().stage, WorkStage::kDone) << "one step";
}

TEST_F(TimeSpent, IsThatDuringWhichTheObjectWasPlacedSelectedOrRefined) {
  WorkFor(10);  // looks round: on nothing
  WorkFor(2, true);
  WorkFor(6, true);  // with the model in the hand; the first two seconds chose it
  Place("armchair", scene_.scan_from_armchair);
  EXPECT_DOUBLE_EQ(SavedSpent("armchair_0"), 6 + 3);
  WorkFor(4, true);  // looks for where the table stands: no longer the chair's
  Place("table", scene_.scan_from_table);
  EXPECT_DOUBLE_EQ(SavedSpent("table_0"), 4 + 3);
  After(0, ActivityCommand{});
  After(0, SelectInstanceCommand{"armchair_0"});
  WorkFor(20);
  EXPECT_DOUBLE_EQ(ShownSpent("armchair_0"), 9 + 20) << "at once";
  EXPECT_DOUBLE_EQ(SavedSpent("armchair_0"), 9);
  After(0, SelectInstanceCommand{"table_0"});
  WorkFor(1);
  Nudge("table_0");
  EXPECT_DOUBLE_EQ(SavedSpent("armchair_0"), 29) << "with the next edit, whosever";
  EXPECT_DOUBLE_EQ(SavedSpent("table_0"), 8);
  EXPECT_EQ(session_->Snapshot().undo_label, "Move table_0");
}

TEST_F(TimeSpent, IsWrittenInTenthsHoweverManyAddUp) {
  Place("armchair", scene_.scan_from_armchair);
  After(0, ActivityCommand{});
  for (int i = 0; i < 20; ++i) {
    WorkFor(0.17);
    Nudge("armchair_0");
  }
  const std::string text = nlohmann::json(SavedSpent("armchair_0")).dump();
  EXPECT_LE(text.size() - text.find('.'), 2u) << text;
  EXPECT_NEAR(SavedSpent("armchair_0"), 3 + 20 * 0.17, 0.1 + 1e-6) << "and none is lost";
}

TEST_F(TimeSpent, PausesDoNotCount) {
  Place("armchair", scene_.scan_from_armchair);
  After(0, ActivityCommand{});
  const double before = SavedSpent("armchair_0");
  After(61, ActivityCommand{});
  After(3600, ActivityCommand{});
  EXPECT_DOUBLE_EQ(ShownSpent("armchair_0"), before);
  After(59, ActivityCommand{});
  EXPECT_DOUBLE_EQ(ShownSpent("armchair_0"), before + 59) << "no pause, a thought";
}

TEST_F(TimeSpent, UndoTakesNoTimeBack) {
  Place("armchair", scene_.scan_from_armchair);
  After(0, ActivityCommand{});
  WorkFor(10);
  Nudge("armchair_0");
  const double spent = SavedSpent("armchair_0");
  After(0, UndoCommand{});
  EXPECT_DOUBLE_EQ(ShownSpent("armchair_0"), spent);
  After(0, RedoCommand{});
  EXPECT_DOUBLE_EQ(ShownSpent("armchair_0"), spent) << "and counts none twice";
  After(0, UndoCommand{});
  Nudge("armchair_0");
  EXPECT_DOUBLE_EQ(SavedSpent("armchair_0"), spent);
}

TEST_F(TimeSpent, GoesWithTheObjectThatIsWorkedOnInsteadAndWithItsNewName) {
  Place("armchair", scene_.scan_from_armchair);
  After(0, ActivityCommand{true});  // the model is still chosen, ...
  const double before = ShownSpent("armchair_0");
  WorkFor(6, true);
  Nudge("armchair_0");  // ... but the last one is moved
  EXPECT_DOUBLE_EQ(SavedSpent("armchair_0"), before + 6);
  WorkFor(4, true);
  After(0, ActivityCommand{});  // Esc: nothing is placed
  EXPECT_DOUBLE_EQ(ShownSpent("armchair_0"), before + 10) << "it is selected";
  ChangeInstanceCommand rename;
  rename.id = "armchair_0";
  rename.set.id = "seat";
  After(0, rename);
  EXPECT_DOUBLE_EQ(SavedSpent("seat"), before + 10);
  WorkFor(4);
  After(0, RemoveInstanceCommand{"seat"});
  EXPECT_EQ(session_->Snapshot().undo_label, "Remove seat");
  After(0, UndoCommand{});
  EXPECT_DOUBLE_EQ(ShownSpent("seat"), before + 10);
}

TEST_F(AnnotationSessionTest, AnotherPersonReviewsAndSaysSo) {
  const auto session = WithArmchair();
  EXPECT_EQ(session->Snapshot().stage, WorkStage::kInWork);
  Do(*session, SetStageCommand{WorkStage::kToReview, "the left leg is hidden"});
  EXPECT_EQ(session->Snapshot().project_state->annotator, "Ada");
  Do(*session, SetStageCommand{WorkStage::kDone, ""});
  EXPECT_TRUE(session->Snapshot().refused) << "she handed it over herself";
  EXPECT_EQ(session->Snapshot().stage, WorkStage::kToReview);
  Do(*session, SetAnnotatorCommand{"Grace"});
  Do(*session, SetStageCommand{WorkStage::kInWork, "it floats"});
  EXPECT_EQ(session->Snapshot().project_state->reviewer, "Grace");
  EXPECT_EQ(session->Snapshot().undo_label, "Take it back to work");
  Do(*session, UndoCommand{});
  EXPECT_EQ(session->Snapshot().stage, WorkStage::kToReview);
  Do(*session, SetStageCommand{WorkStage::kDone, ""});
  EXPECT_EQ(session->Snapshot().answer, "Done, and reviewed by Grace");
  session->Close();
  const auto again = Open();
  EXPECT_EQ(again->Snapshot().stage, WorkStage::kDone);
}

/// The scene's scan and project, a second scan that nobody began, one that is done, and models.
class Queue : public AnnotationSessionTest {
 protected:
  void SetUp() override {
    WithArmchair();  // only in the journal
    const std::filesystem::path folder = folder_.path();
    std::filesystem::create_directories(folder / "office");
    std::filesystem::copy_file(scene_.scan, folder / "office" / "room.ply");
    std::filesystem::copy_file(scene_.scan, folder / "attic.ply");
    AnnotationDocument document;
    document.scan = "attic.ply";
    document.state = ProjectState{WorkStage::kDone, "Grace", "Ada", "fine"};
    ASSERT_TRUE(AnnotationProject::Create(folder / "attic.grace.json", document).ok());
    ASSERT_TRUE(WriteFileAtomically(folder / "broken.annotation.json",
                                    R"({"plumbline_annotation": 1, "instances": 3})")
                    .ok());
    ASSERT_TRUE(WriteFileAtomically(folder / "other.json", "{}").ok());
  }
};

TEST_F(Queue, ListsScansAndProjectsWithTheirState) {
  const auto entries = ReadQueue(folder_.path()).value();
  ASSERT_EQ(entries.size(), 4u) << "no models, each scan once";
  EXPECT_EQ(entries[0].name, "attic.grace.json");
  EXPECT_EQ(entries[0].stage, WorkStage::kDone);
  EXPECT_EQ(entries[0].reviewer, "Ada");
  EXPECT_EQ(entries[0].annotators, std::vector<std::string>{"Grace"});
  EXPECT_THAT(entries[1].problem, testing::HasSubstr("instances"));
  EXPECT_EQ(entries[2].name, "office/room.ply");
  EXPECT_EQ(entries[2].stage, WorkStage::kNew);
  EXPECT_EQ(entries[3].name, "scan.annotation.json");
  EXPECT_EQ(entries[3].stage, WorkStage::kInWork);
  EXPECT_EQ(entries[3].objects, 1u) << "it is in the journal";
  EXPECT_GT(entries[3].seconds, 0);
  EXPECT_EQ(FirstToDo(entries), 3u);
  EXPECT_TRUE(IsQueue(folder_.path()));
  EXPECT_FALSE(IsQueue(scene_.models));
  std::filesystem::create_directories(folder_.path() / "cam0");
  EXPECT_FALSE(IsQueue(folder_.path())) << "a sequence of EuRoC may come with a scan";
  EXPECT_FALSE(ReadQueue(folder_.path() / "none").ok());
}

TEST_F(Queue, AFolderOpensAtWhatIsToBeDoneAndListsTheRest) {
  const auto session = Open(folder_.path());
  EXPECT_EQ(session->Snapshot().project_name, "scan.annotation.json");
  ASSERT_TRUE(session->Snapshot().queue.has_value());
  const AnnotationQueueView queue = *session->Snapshot().queue;
  ASSERT_EQ(queue.entries.size(), 4u);
  EXPECT_EQ(queue.open, 3u);
  Do(*session, SetStageCommand{WorkStage::kToReview, ""});
  EXPECT_EQ(session->Snapshot().queue->entries[3].stage, WorkStage::kToReview) << "at once";
  Do(*session, ListQueueCommand{(folder_.path() / "office").string()});
  EXPECT_EQ(session->Snapshot().queue->entries.size(), 1u);
  EXPECT_FALSE(session->Snapshot().queue->open.has_value());
  std::filesystem::create_directory(folder_.path() / "empty");
  EXPECT_FALSE(AnnotationSession::Open({folder_.path() / "empty", {}, {}, "", {}}).ok());
}

TEST_F(AnnotationSessionTest, ACopyLandsBesideOnAFreeSideAndIsSelectedAndFree) {
  const auto session = WithArmchair();
  ChangeInstanceCommand lock;
  lock.id = "armchair_0";
  lock.set.locked = true;
  Do(*session, lock);
  const auto models = ModelDatabase::Load(scene_.models).value();
  const Eigen::Vector3d size =
      models->model(*models->Find("armchair")).bounds.sizes().cast<double>();
  std::vector<Eigen::Vector3d> in_first;
  for (int i = 1; i <= 5; ++i) {
    Do(*session, DuplicateInstanceCommand{"armchair_0"});
    const AnnotationSnapshot now = session->Snapshot();
    EXPECT_EQ(now.selected, "armchair_" + std::to_string(i));
    EXPECT_FALSE(now.Selected()->locked);
    const Eigen::Isometry3d first = now.instances[0].scan_from_object;
    in_first.push_back((first.inverse() * now.Selected()->scan_from_object).translation());
    EXPECT_NEAR(in_first.back().z(), 0, 1e-9) << "as high";
    EXPECT_EQ(now.Selected()->scan_from_object.linear(), first.linear());
  }
  EXPECT_NEAR(in_first[0].y(), 1.05 * size.y(), 1e-9) << "to the left, by its width";
  EXPECT_NEAR(in_first[1].y(), -1.05 * size.y(), 1e-9) << "the left is taken";
  EXPECT_NEAR(in_first[2].x(), -1.05 * size.x(), 1e-9);
  EXPECT_NEAR(in_first[3].x(), 1.05 * size.x(), 1e-9);
  EXPECT_NEAR(in_first[4].y(), 2.1 * size.y(), 1e-9) << "all four are taken";
}

TEST_F(AnnotationSessionTest, OnlyWhatMayTiltIsTiltedByRefining) {
  const auto session = WithArmchair();
  const Eigen::Isometry3d upright = session->Snapshot().instances[0].scan_from_object;
  const auto tilt_deg = [&] {
    const UprightFrame frame(session->project().document().gravity_in_scan);
    return frame.Tilt(session->Snapshot().refinement->scan_from_object.linear()) * 180 /
           std::numbers::pi;
  };
  Eigen::Isometry3d tilted = upright;
  tilted.linear() *= Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitX()).toRotationMatrix();
  Do(*session, SetInstancePoseCommand{"armchair_0", tilted});
  Do(*session, RefineInstanceCommand{"armchair_0", false});
  EXPECT_NEAR(tilt_deg(), 0.03 * 180 / std::numbers::pi, 1e-6) << "the tilt stays";
  Do(*session, CancelProposalCommand{});
  ChangeInstanceCommand unlock;
  unlock.id = "armchair_0";
  unlock.set.may_tilt = true;
  Do(*session, unlock);
  Do(*session, RefineInstanceCommand{"armchair_0", false});
  EXPECT_LT(tilt_deg(), 0.2) << "the scan shows it upright";
  EXPECT_THAT(session->Snapshot().refinement->scan_from_object, IsometryNear(upright, 0.2, 0.002));
}

}  // namespace
}  // namespace plumbline
