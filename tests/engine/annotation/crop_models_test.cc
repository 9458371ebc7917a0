// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/crop_models.h"

#include <gtest/gtest.h>

#include "engine/base/files.h"
#include "engine/models/model_move.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using std::filesystem::exists;
using std::filesystem::path;

/// A project with a database in which a crop makes the model "stool".
class CropModels : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(StoreModel(Built("table"), models_).ok());
    AnnotationDocument document;
    document.models = "models";
    auto project = AnnotationProject::Create(file_, document);
    ASSERT_TRUE(project.ok()) << project.error().message;
    project_ = std::move(*project);
  }

  static BuiltModel Built(const std::string& name) {
    ModelBuildOptions options;
    options.unit = LengthUnit::kMetre;
    options.up = SignedAxis{2, 1};
    options.front = SignedAxis{0, 1};
    return BuildModelFrom({MakeBox({0, 0, 0}, {0.4f, 0.3f, 0.5f}), {}, {}, {}}, name, "scan.ply",
                          options)
        .value();
  }
  static EditGroup CutStool() {
    Crop crop;
    crop.id = "stool";
    crop.region = CropBox{};
    crop.up_in_scan = Eigen::Vector3d(0, 0, 1);
    crop.without_support = false;
    AnnotatedInstance instance;
    instance.id = "stool_0";
    instance.model = "stool";
    return {"Cut out stool", {AddCrop{crop, std::nullopt}, AddInstance{instance, std::nullopt}}};
  }
  void Cut() {
    ASSERT_TRUE(StageCropModel(Built("stool"), models_).ok());
    ASSERT_TRUE(project_->Apply(CutStool()).ok());
    ASSERT_TRUE(SyncCropModels(*project_).value());
  }
  /// As after kill -9: what is in memory is lost, what is on the disk is not.
  void KillAndOpen() {
    const TemporaryFolder rescued;
    const path copy = rescued.path() / "journal";
    const path journal = file_.string() + ".journal";
    if (exists(journal)) std::filesystem::copy_file(journal, copy);
    const std::string content = ReadFile(file_).value();
    project_.reset();
    ASSERT_TRUE(WriteFileAtomically(file_, content).ok());
    if (exists(copy))
      std::filesystem::copy_file(copy, journal, std::filesystem::copy_options::overwrite_existing);
    auto project = AnnotationProject::Open(file_);
    ASSERT_TRUE(project.ok()) << project.error().message;
    project_ = std::move(*project);
    ASSERT_TRUE(SyncCropModels(*project_).ok());
  }
  bool InDatabase(const std::string& name) const {
    const bool listed = HasModel(models_, name);
    EXPECT_EQ(exists(models_ / (name + ".ply")), listed) << "no file without an entry";
    return listed;
  }

  TemporaryFolder folder_;
  path models_ = folder_.path() / "models", file_ = folder_.path() / "project.json";
  std::unique_ptr<AnnotationProject> project_;
};

TEST_F(CropModels, ComeAndGoWithUndoAndRedo) {
  Cut();
  EXPECT_TRUE(InDatabase("stool"));
  EXPECT_FALSE(SyncCropModels(*project_).value()) << "nothing to do";
  EXPECT_FALSE(exists(UndoneModels(models_))) << "nothing waits there";
  ASSERT_TRUE(project_->Undo().ok());
  EXPECT_TRUE(SyncCropModels(*project_).value());
  EXPECT_FALSE(InDatabase("stool"));
  EXPECT_TRUE(InDatabase("table"));
  ASSERT_TRUE(project_->Redo().ok());
  EXPECT_TRUE(SyncCropModels(*project_).value());
  EXPECT_TRUE(InDatabase("stool"));
  const auto loaded = ModelDatabase::Load(models_);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message;
  EXPECT_EQ((*loaded)->models().size(), 2u);
}

TEST_F(CropModels, FollowTheJournalWhereverTheProcessWasKilled) {
  ASSERT_TRUE(StageCropModel(Built("stool"), models_).ok());
  KillAndOpen();  // staged, but the edit never happened
  EXPECT_FALSE(InDatabase("stool"));
  ASSERT_TRUE(StageCropModel(Built("stool"), models_).ok());
  ASSERT_TRUE(project_->Apply(CutStool()).ok());
  KillAndOpen();  // after the edit, before the database followed
  EXPECT_TRUE(InDatabase("stool"));
  ASSERT_TRUE(project_->Undo().ok());
  KillAndOpen();  // likewise after an undo
  EXPECT_FALSE(InDatabase("stool"));
  ASSERT_TRUE(project_->Redo().ok());
  KillAndOpen();
  EXPECT_TRUE(InDatabase("stool"));
}

TEST_F(CropModels, AMoveThatWasCutShortIsFinished) {
  Cut();
  // In both databases, as between the two lists of a move.
  ASSERT_TRUE(StageCropModel(Built("stool"), models_).ok());
  ASSERT_TRUE(SyncCropModels(*project_).ok());
  EXPECT_TRUE(InDatabase("stool"));
  EXPECT_FALSE(HasModel(UndoneModels(models_), "stool"));
  ASSERT_TRUE(StageCropModel(Built("stool"), models_).ok());
  ASSERT_TRUE(project_->Undo().ok());
  ASSERT_TRUE(SyncCropModels(*project_).ok());
  EXPECT_FALSE(InDatabase("stool"));
  EXPECT_TRUE(HasModel(UndoneModels(models_), "stool"));
}

TEST_F(CropModels, AModelThatAnObjectStillUsesStays) {
  Cut();
  ASSERT_TRUE(project_->Apply(RemoveCrop{"stool"}).ok());
  ASSERT_TRUE(SyncCropModels(*project_).ok());
  EXPECT_TRUE(InDatabase("stool"));
}

}  // namespace
}  // namespace plumbline
