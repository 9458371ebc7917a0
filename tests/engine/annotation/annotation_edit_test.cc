// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_edit.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/engine/annotation/random_edits.h"
#include "tests/support/random_pose.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

std::string Text(const AnnotationDocument& document) { return DocumentToJson(document).dump(); }

TEST(AnnotationEdit, EveryEditIsTakenBackExactly) {
  AnnotationDocument document;
  Random random({.seed = 1});
  std::vector<std::string> states{Text(document)};
  std::vector<Edit> back;
  for (int i = 0; i < 2000; ++i) {
    Result<Edit> undo = ApplyEdit(RandomEdit(document, random), document);
    ASSERT_TRUE(undo.ok()) << undo.error().message;
    back.push_back(std::move(*undo));
    states.push_back(Text(document));
  }
  while (!back.empty()) {
    ASSERT_TRUE(ApplyEdit(back.back(), document).ok());
    back.pop_back();
    states.pop_back();
    ASSERT_EQ(Text(document), states.back());
  }
}

TEST(AnnotationEdit, SurvivesJsonBitForBit) {
  AnnotationDocument document, copy;
  Random random({.seed = 2});
  for (int i = 0; i < 500; ++i) {
    const Edit edit = RandomEdit(document, random);
    const Result<Edit> read = EditFromJson(nlohmann::json::parse(EditToJson(edit).dump()));
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_TRUE(ApplyEdit(edit, document).ok());
    ASSERT_TRUE(ApplyEdit(*read, copy).ok());
    ASSERT_EQ(Text(copy), Text(document));
  }
  const auto again = DocumentFromJson(nlohmann::json::parse(Text(document)));
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(Text(*again), Text(document));
}

TEST(AnnotationEdit, RefusesWhatMakesNoSenseAndLeavesTheDocument) {
  AnnotationDocument document;
  Random random({.seed = 3});
  ASSERT_TRUE(ApplyEdit(AddInstance{RandomInstance("a", random), {}}, document).ok());
  ASSERT_TRUE(ApplyEdit(AddInstance{RandomInstance("b", random), {}}, document).ok());
  const std::string before = Text(document);
  ChangeInstance taken, skewed, negative, nobody;
  taken.id = skewed.id = negative.id = "a";
  nobody.id = "c";
  taken.set.id = "b";
  skewed.set.scan_from_object = Eigen::Isometry3d::Identity();
  skewed.set.scan_from_object->linear() *= 1.1;
  negative.set.seconds_spent = -1;
  const std::vector<Edit> wrong = {
      AddInstance{RandomInstance("a", random), {}}, AddInstance{RandomInstance("", random), {}},
      RemoveInstance{"c"}, taken, skewed, negative, nobody, SetGravity{{0, 0, -2}, {}},
      SetGravity{{0, 0, -1}, Eigen::Vector4d(1, 0, 0, 0)},
      SetState{ProjectState{WorkStage::kNew, "Ada"}}, SetState{ProjectState{WorkStage::kDone, ""}},
      SetState{ProjectState{WorkStage::kDone, "Ada", "Ada"}},
      // The first of the two is good: neither may stay.
      EditGroup{"both", {RemoveInstance{"b"}, RemoveInstance{"b"}}}};
  for (const Edit& edit : wrong) {
    EXPECT_FALSE(ApplyEdit(edit, document).ok()) << DescribeEdit(edit);
    EXPECT_EQ(Text(document), before);
  }
}

TEST(AnnotationEdit, HowFarTheWorkIsGoesThroughUndoAndTheFile) {
  AnnotationDocument document;
  EXPECT_EQ(document.Stage(), WorkStage::kNew);
  Random random({.seed = 6});
  ASSERT_TRUE(ApplyEdit(AddInstance{RandomInstance("a", random), {}}, document).ok());
  EXPECT_EQ(document.Stage(), WorkStage::kInWork) << "also of a project that knows no states";
  const std::string before = Text(document);
  EXPECT_EQ(before.find("state"), std::string::npos);
  const auto back =
      ApplyEdit(SetState{ProjectState{WorkStage::kDone, "Ada", "Grace", "good"}}, document);
  ASSERT_TRUE(back.ok());
  const auto read = DocumentFromJson(nlohmann::json::parse(Text(document)));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->state, document.state);
  EXPECT_EQ(read->Stage(), WorkStage::kDone);
  ASSERT_TRUE(ApplyEdit(*back, document).ok());
  EXPECT_EQ(Text(document), before);
}

TEST(ProjectState, ASecondPersonReviews) {
  using enum WorkStage;
  EXPECT_FALSE(NextState({}, kToReview, "", "").ok()) << "by whom?";
  const auto handed_over = NextState({}, kToReview, "Ada", "all but the lamp");
  ASSERT_TRUE(handed_over.ok());
  EXPECT_EQ(*handed_over, (ProjectState{kToReview, "Ada", "", "all but the lamp"}));
  EXPECT_FALSE(NextState(*handed_over, kDone, "Ada", "").ok()) << "her own";
  EXPECT_EQ(NextState(*handed_over, kInWork, "Ada", "").value(), (ProjectState{kInWork, "Ada"}));
  EXPECT_EQ(NextState(*handed_over, kDone, "Grace", "").value(),
            (ProjectState{kDone, "Ada", "Grace"}));
  const auto sent_back = NextState(*handed_over, kInWork, "Grace", "chair_2 floats");
  EXPECT_EQ(*sent_back, (ProjectState{kInWork, "Ada", "Grace", "chair_2 floats"}));
  EXPECT_EQ(NextState(*sent_back, kToReview, "Ada", "").value(), (ProjectState{kToReview, "Ada"}));
  EXPECT_EQ(NextState({}, kDone, "Ada", "").value(), (ProjectState{kDone, "Ada"}))
      << "nobody reviewed it";
  EXPECT_FALSE(NextState(*handed_over, kToReview, "Grace", "").ok()) << "it is that already";
}

TEST(AnnotationEdit, ALockedInstanceStaysWhereItIs) {
  AnnotationDocument document;
  Random random({.seed = 4});
  ASSERT_TRUE(ApplyEdit(AddInstance{RandomInstance("a", random), {}}, document).ok());
  ChangeInstance lock, move, note, unlock;
  lock.id = move.id = note.id = unlock.id = "a";
  lock.set.locked = true;
  move.set.scan_from_object = RandomPose(random);
  note.set.note = "good";
  unlock.set.locked = false;
  ASSERT_TRUE(ApplyEdit(lock, document).ok());
  EXPECT_FALSE(ApplyEdit(move, document).ok());
  EXPECT_FALSE(ApplyEdit(RemoveInstance{"a"}, document).ok());
  EXPECT_TRUE(ApplyEdit(note, document).ok());
  ASSERT_TRUE(ApplyEdit(unlock, document).ok());
  EXPECT_TRUE(ApplyEdit(move, document).ok());
}

TEST(AnnotationEdit, JsonMistakesAreSentences) {
  const auto message = [](const char* text) {
    const auto edit = EditFromJson(nlohmann::json::parse(text));
    return edit.ok() ? std::string("no error") : edit.error().message;
  };
  EXPECT_THAT(message(R"({"edit": "paint"})"), testing::HasSubstr("not 'paint'"));
  EXPECT_THAT(message(R"({"edit": "change", "id": "a", "colour": 1})"),
              testing::HasSubstr("knows no 'colour'"));
  EXPECT_THAT(message(R"({"edit": "change", "id": "a", "scan_from_object": [1, 2]})"),
              testing::HasSubstr("wrong value"));
  EXPECT_THAT(message(R"({"edit": "add", "instance": {"id": "a"}})"),
              testing::HasSubstr("needs a text 'model'"));
}

/// Every field by its key, in a file and in a change, so that a new one cannot be forgotten.
TEST(AnnotatedInstance, EveryFieldIsWrittenReadChangedAndTakenBack) {
  Random random({.seed = 5});
  AnnotatedInstance before = RandomInstance("a", random), after = RandomInstance("b", random);
  after.model = "table";
  after.category = "dining table";
  after.fine = !before.fine;
  after.note = "wobbles";
  after.annotator = "Grace";
  after.hidden = after.locked = true;
  EXPECT_EQ(InstanceToJson(InstanceFromJson(InstanceToJson(after)).value()), InstanceToJson(after));
  InstanceChange change;
  VisitInstance([](const InstanceField&, auto& set, const auto& value) { set = value; }, change,
                after);
  const InstanceChange read =
      ChangeFromJson(nlohmann::json::parse(ChangeToJson(change).dump())).value();
  AnnotatedInstance instance = before;
  const InstanceChange back = ChangeFields(read, instance);
  EXPECT_EQ(InstanceToJson(instance), InstanceToJson(after));
  ChangeFields(back, instance);
  EXPECT_EQ(InstanceToJson(instance), InstanceToJson(before));
}

TEST(AnnotatedInstance, AValueOfTheWrongKindIsAnErrorAndNotTheDefault) {
  Random random({.seed = 6});
  nlohmann::json json = InstanceToJson(RandomInstance("a", random));
  json["locked"] = "yes";
  const auto read = InstanceFromJson(json);
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().message, "instance 'a' has a 'locked' that is neither true nor false");
}

TEST(AnnotationDocument, LevelsTheScanFromGravityAndFloor) {
  AnnotationDocument document;
  document.gravity_in_scan = {-1, 0, 0};
  document.floor_in_scan = Eigen::Vector4d(1, 0, 0, -0.5);  // x = 0.5
  const Eigen::Vector3d level = document.LevelFromScan() * Eigen::Vector3d(2.5, 3, 4);
  EXPECT_NEAR(level.z(), 2, 1e-12);
}

}  // namespace
}  // namespace plumbline
