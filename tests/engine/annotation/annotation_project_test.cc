// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_project.h"

#include <signal.h>
#include <sys/resource.h>

#include <fstream>
#include <functional>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "tests/engine/annotation/random_edits.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

class AnnotationProjectTest : public testing::Test {
 protected:
  std::unique_ptr<AnnotationProject> Create() const {
    return AnnotationProject::Create(file_, {}).value();
  }
  std::unique_ptr<AnnotationProject> Open() const { return AnnotationProject::Open(file_).value(); }
  static std::string Text(const AnnotationProject& project) {
    return DocumentToJson(project.document()).dump();
  }
  void Edit(AnnotationProject& project, int count) {
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(project.Apply(RandomEdit(project.document(), random_)).ok());
    }
  }
  /// The files as a process that is killed now would leave them.
  void KillHere(std::unique_ptr<AnnotationProject> project) const {
    const auto journal = ReadFile(file_.string() + ".journal");
    project.reset();
    ASSERT_TRUE(journal.ok());
    ASSERT_TRUE(WriteFileAtomically(file_.string() + ".journal", *journal).ok());
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "room.json";
  Random random_{{.seed = 5}};
};

TEST_F(AnnotationProjectTest, SavesAndOpensAgain) {
  auto project = Create();
  Edit(*project, 30);
  EXPECT_TRUE(project->modified());
  ASSERT_TRUE(project->Save().ok());
  EXPECT_FALSE(project->modified());
  const std::string text = Text(*project);
  project.reset();
  EXPECT_FALSE(std::filesystem::exists(file_.string() + ".journal"));
  project = Open();
  EXPECT_EQ(Text(*project), text);
  EXPECT_EQ(project->num_recovered(), 0u);
  EXPECT_TRUE(project->warnings().empty());
}

TEST_F(AnnotationProjectTest, UndoesAndRedoesWithoutEnd) {
  auto project = Create();
  std::vector<std::string> states{Text(*project)};
  for (int i = 0; i < 300; ++i) {
    Edit(*project, 1);
    states.push_back(Text(*project));
  }
  for (int i = 299; i >= 0; --i) {
    ASSERT_TRUE(project->Undo().ok());
    ASSERT_EQ(Text(*project), states[static_cast<std::size_t>(i)]);
  }
  EXPECT_FALSE(project->Undo().ok());
  for (std::size_t i = 1; i <= 300; ++i) {
    ASSERT_TRUE(project->Redo().ok());
    ASSERT_EQ(Text(*project), states[i]);
  }
  EXPECT_FALSE(project->RedoLabel().has_value());
  ASSERT_TRUE(project->Undo().ok());
  Edit(*project, 1);
  EXPECT_FALSE(project->RedoLabel().has_value());
}

TEST_F(AnnotationProjectTest, WhatWasNotSavedComesBackWithItsUndo) {
  auto project = Create();
  Edit(*project, 10);
  ASSERT_TRUE(project->Save().ok());
  const std::string saved = Text(*project);
  Edit(*project, 7);
  ASSERT_TRUE(project->Undo().ok());
  const std::string last = Text(*project);
  KillHere(std::move(project));
  project = Open();
  EXPECT_EQ(Text(*project), last);
  EXPECT_EQ(project->num_recovered(), 8u);
  EXPECT_TRUE(project->modified());
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(project->Undo().ok());
  EXPECT_EQ(Text(*project), saved);
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(project->Redo().ok());
  EXPECT_EQ(Text(*project), last);
  // And once more, with the journal that was continued.
  Edit(*project, 2);
  const std::string after = Text(*project);
  KillHere(std::move(project));
  EXPECT_EQ(Text(*Open()), after);
}

TEST_F(AnnotationProjectTest, UndoingPastTheLastSaveSurvivesAKill) {
  auto project = Create();
  Edit(*project, 5);
  const std::string five = Text(*project);
  Edit(*project, 3);
  ASSERT_TRUE(project->Save().ok());
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(project->Undo().ok());
  KillHere(std::move(project));
  EXPECT_EQ(Text(*Open()), five);
}

TEST_F(AnnotationProjectTest, UndoAndRedoReachBehindASaveAndTheNextStart) {
  auto project = Create();
  std::vector<std::string> states = {Text(*project)};
  for (int i = 0; i < 12; ++i) {
    Edit(*project, 1);
    states.push_back(Text(*project));
    if (i == 5) {
      ASSERT_TRUE(project->Save().ok());
    }
  }
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(project->Undo().ok());
  ASSERT_TRUE(project->Save().ok());
  project.reset();
  project = Open();
  EXPECT_EQ(project->num_recovered(), 0u);
  for (int i = 9; i > 2; --i) {
    EXPECT_EQ(Text(*project), states[static_cast<std::size_t>(i)]) << i;
    ASSERT_TRUE(project->Undo().ok());
  }
  // Saved in the middle of it, and killed after another step.
  ASSERT_TRUE(project->Save().ok());
  ASSERT_TRUE(project->Redo().ok());
  KillHere(std::move(project));
  project = Open();
  EXPECT_EQ(project->num_recovered(), 1u);
  for (int i = 3; i < 12; ++i) {
    EXPECT_EQ(Text(*project), states[static_cast<std::size_t>(i)]) << i;
    ASSERT_TRUE(project->Redo().ok()) << i;
  }
  EXPECT_EQ(Text(*project), states[12]);
  while (project->UndoLabel()) ASSERT_TRUE(project->Undo().ok());
  EXPECT_EQ(Text(*project), states[0]);
}

TEST_F(AnnotationProjectTest, AnUndoHistoryOfAnotherVersionIsNotUsed) {
  auto project = Create();
  Edit(*project, 4);
  ASSERT_TRUE(project->Save().ok());
  project.reset();
  const std::string old = *ReadFile(file_.string() + ".undo");
  project = Open();
  Edit(*project, 2);
  ASSERT_TRUE(project->Save().ok());
  const std::string text = Text(*project);
  project.reset();
  ASSERT_TRUE(WriteFileAtomically(file_.string() + ".undo", old).ok());
  project = Open();
  EXPECT_FALSE(project->UndoLabel().has_value());
  EXPECT_EQ(Text(*project), text);
  project.reset();
  for (const char* damaged : {"", "{", "[3]", "{\"base\": 4}"}) {
    ASSERT_TRUE(WriteFileAtomically(file_.string() + ".undo", damaged).ok());
    EXPECT_EQ(Text(*Open()), text) << damaged;
  }
}

TEST_F(AnnotationProjectTest, WhatWasRecoveredIsUndoneDownToWhatWasSavedAndNoFarther) {
  auto project = Create();
  Edit(*project, 5);
  ASSERT_TRUE(project->Save().ok());
  const std::string saved = Text(*project);
  Edit(*project, 2);
  ASSERT_TRUE(project->Undo().ok());
  ASSERT_TRUE(project->Redo().ok());
  KillHere(std::move(project));
  project = Open();
  EXPECT_EQ(project->num_recovered(), 4u);
  EXPECT_EQ(project->UndoRecovered().value(), true);
  EXPECT_EQ(Text(*project), saved);
  ASSERT_TRUE(project->Save().ok());
  // Saved steps that were undone come back.
  ASSERT_TRUE(project->Undo().ok());
  ASSERT_TRUE(project->Undo().ok());
  KillHere(std::move(project));
  project = Open();
  EXPECT_EQ(project->UndoRecovered().value(), true);
  EXPECT_EQ(Text(*project), saved);
  // Unless the work went on from there.
  ASSERT_TRUE(project->Save().ok());
  ASSERT_TRUE(project->Undo().ok());
  const std::string undone = Text(*project);
  Edit(*project, 2);
  KillHere(std::move(project));
  project = Open();
  EXPECT_EQ(project->UndoRecovered().value(), false);
  EXPECT_EQ(Text(*project), undone);
}

TEST_F(AnnotationProjectTest, ATornLineEndsTheJournalAndNothingElse) {
  auto project = Create();
  Edit(*project, 6);
  const std::string last = Text(*project);
  KillHere(std::move(project));
  std::ofstream(file_.string() + ".journal", std::ios::app) << R"({"kind": "do", "edit": {"ed)";
  project = Open();
  EXPECT_EQ(Text(*project), last);
  Edit(*project, 3);
  const std::string after = Text(*project);
  KillHere(std::move(project));
  EXPECT_EQ(Text(*Open()), after);
}

TEST_F(AnnotationProjectTest, AJournalOfAnotherVersionIsKeptAside) {
  auto project = Create();
  Edit(*project, 6);
  KillHere(std::move(project));
  nlohmann::json other = ReadJson(file_).value();  // as from a version control system
  other["saved"] = {{"journal", "other"}, {"records", 0}};
  ASSERT_TRUE(WriteJson(file_, other).ok());
  project = Open();
  ASSERT_EQ(project->warnings().size(), 1u);
  EXPECT_THAT(project->warnings()[0], testing::HasSubstr("kept as"));
  EXPECT_TRUE(project->document().instances.empty());
  int kept = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
    kept += entry.path().string().find(".journal.kept-") != std::string::npos;
  }
  EXPECT_EQ(kept, 1);
}

TEST_F(AnnotationProjectTest, ASecondWindowIsToldWhoHasTheProject) {
  auto project = Create();
  const auto second = AnnotationProject::Open(file_);
  ASSERT_FALSE(second.ok());
  EXPECT_THAT(second.error().message,
              testing::AllOf(testing::HasSubstr("open in another window"),
                             testing::HasSubstr("process " + std::to_string(getpid()))));
  Edit(*project, 3);
  auto reader = AnnotationProject::Open(file_, AnnotationProject::Access::kRead);
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ(Text(**reader), Text(*project));
  EXPECT_FALSE((*reader)->Apply(RemoveInstance{"x"}).ok());
  EXPECT_FALSE((*reader)->Save().ok());
  // Looking does not disturb: the writer's edits are still recovered.
  reader->reset();
  KillHere(std::move(project));
  EXPECT_EQ(Open()->num_recovered(), 3u);
}

TEST_F(AnnotationProjectTest, OnAFullDiskWorkStaysInMemoryAndIsSavedLater) {
  auto project = Create();
  Edit(*project, 3);
  rlimit old;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  rlimit full = old;
  full.rlim_cur = std::filesystem::file_size(file_.string() + ".journal") + 100;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
  Edit(*project, 20);
  const bool reported = project->journal_problem().has_value();
  const std::string problem = reported ? project->journal_problem()->message : "";
  const Status saved = project->Save();
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
  signal(SIGXFSZ, handler);
  EXPECT_TRUE(reported);
  EXPECT_THAT(problem, testing::HasSubstr("save it elsewhere"));
  EXPECT_FALSE(saved.ok());
  const std::string text = Text(*project);
  // There is room again: the next edit writes what waited.
  Edit(*project, 1);
  EXPECT_FALSE(project->journal_problem().has_value());
  const std::string last = Text(*project);
  ASSERT_TRUE(project->Undo().ok());
  EXPECT_EQ(Text(*project), text);
  ASSERT_TRUE(project->Redo().ok());
  KillHere(std::move(project));
  project = Open();
  EXPECT_EQ(Text(*project), last);
  EXPECT_EQ(project->num_recovered(), 26u);
}

TEST_F(AnnotationProjectTest, IsSavedElsewhereWithPathsThatFit) {
  auto project = Create();
  ASSERT_TRUE(project->Apply(SetInputs{"scan.ply", "../models", "/data/walk"}).ok());
  Edit(*project, 2);
  std::filesystem::create_directories(folder_.path() / "a" / "b");
  const auto scan = std::filesystem::weakly_canonical(project->Resolve("scan.ply"));
  const Status nowhere = project->SaveAs("/proc/none/room.json");
  EXPECT_FALSE(nowhere.ok());
  EXPECT_EQ(project->file(), file_);
  ASSERT_TRUE(project->SaveAs(folder_.path() / "a" / "b" / "copy.json").ok());
  EXPECT_EQ(std::filesystem::weakly_canonical(project->Resolve(project->document().scan)), scan);
  EXPECT_FALSE(project->modified());
  Edit(*project, 4);
  ASSERT_TRUE(project->Save().ok());
  const std::string text = Text(*project);
  project.reset();
  EXPECT_EQ(Text(*AnnotationProject::Open(folder_.path() / "a" / "b" / "copy.json").value()), text);
  EXPECT_TRUE(AnnotationProject::Open(file_).ok());  // given back
}

TEST_F(AnnotationProjectTest, FilesThatAreNoProjectsAreNamed) {
  const auto message = [&](const char* text) {
    EXPECT_TRUE(WriteFileAtomically(file_, text).ok());
    const auto project = AnnotationProject::Open(file_);
    return project.ok() ? std::string("no error") : project.error().message;
  };
  EXPECT_THAT(message("{}"), testing::HasSubstr("room.json' is not an annotation project"));
  EXPECT_THAT(message(R"({"plumbline_annotation": 2})"), testing::HasSubstr("newer Plumbline"));
  EXPECT_THAT(message(R"({"plumbline_annotation": 1, "instances": [{}]})"),
              testing::HasSubstr("needs a text 'id'"));
  EXPECT_THAT(message("{\"plumbline"), testing::HasSubstr("not valid JSON"));
  EXPECT_FALSE(AnnotationProject::Create(file_, {}).ok());
  EXPECT_FALSE(AnnotationProject::Open(folder_.path() / "none.json").ok());
}

/// Edits of which each stands on its own, unsaved, and their journal.
class DamagedJournal : public AnnotationProjectTest {
 protected:
  DamagedJournal() {
    auto project = Create();
    for (const char* id : {"a", "b", "c", "d"}) {
      EXPECT_TRUE(project->Apply(AddInstance{RandomInstance(id, random_), {}}).ok());
    }
    KillHere(std::move(project));
    journal_ = ReadFile(JournalFile()).value();
  }
  std::string JournalFile() const { return file_.string() + ".journal"; }
  std::vector<std::string> Lines() const {
    std::vector<std::string> lines;
    std::istringstream stream(ReadFile(JournalFile()).value());
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }
  void WriteLines(const std::vector<std::string>& lines) const {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    ASSERT_TRUE(WriteFileAtomically(JournalFile(), text).ok());
  }
  /// Changes the JSON of line `number` as another version might have written it.
  void ChangeLine(std::size_t number, const std::function<void(nlohmann::json&)>& change) const {
    std::vector<std::string> lines = Lines();
    nlohmann::json json = nlohmann::json::parse(lines[number]);
    json.erase("check");
    change(json);
    lines[number] = json.dump();
    WriteLines(lines);
  }
  /// A digit of the edit, so that the line is still JSON.
  void DamageLine(std::size_t number) const {
    std::vector<std::string> lines = Lines();
    char& digit = lines[number][lines[number].find("time_s") + 9];
    digit = digit == '1' ? '2' : '1';
    WriteLines(lines);
  }
  static std::string Ids(const AnnotationProject& project) {
    std::string ids;
    for (const AnnotatedInstance& instance : project.document().instances) ids += instance.id;
    return ids;
  }
  std::string Kept() const {
    std::string kept;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      if (entry.path().string().find(".journal.unreadable-") != std::string::npos)
        kept += ReadFile(entry.path()).value();
    }
    return kept;
  }

  std::string journal_;
};

TEST_F(DamagedJournal, OneBadLineCostsThatEditOnlyAndIsKept) {
  const std::string line = Lines()[2];
  DamageLine(2);
  const std::string damaged = Lines()[2];
  auto project = Open();
  EXPECT_EQ(Ids(*project), "acd");
  EXPECT_EQ(project->num_recovered(), 3u);
  ASSERT_EQ(project->warnings().size(), 1u);
  EXPECT_THAT(project->warnings()[0],
              testing::AllOf(testing::HasSubstr("1 of 4 unsaved edits of '" + file_.string()),
                             testing::HasSubstr("room.json.journal.unreadable-"),
                             testing::HasSubstr("edit 2: it is damaged")));
  EXPECT_EQ(Kept(), damaged + "\n");
  // Killed again, it comes back without the bad line; saved and closed, the line is still there.
  KillHere(std::move(project));
  project = Open();
  EXPECT_EQ(Ids(*project), "acd");
  EXPECT_TRUE(project->warnings().empty());
  ASSERT_TRUE(project->Save().ok());
  project.reset();
  EXPECT_FALSE(std::filesystem::exists(JournalFile()));
  EXPECT_EQ(Kept(), damaged + "\n");
  EXPECT_EQ(Ids(*Open()), "acd");
}

TEST_F(DamagedJournal, WhatANewerVersionWroteOrLacksAnIdIsKept) {
  ChangeLine(1, [](nlohmann::json& line) { line["edit"] = {{"edit", "paint"}, {"id", "a"}}; });
  ChangeLine(2, [](nlohmann::json& line) { line["edit"]["instance"].erase("id"); });
  ChangeLine(3, [](nlohmann::json& line) { line["kind"] = "branch"; });
  auto project = Open();
  EXPECT_EQ(Ids(*project), "d");
  EXPECT_THAT(project->warnings()[0], testing::HasSubstr("3 of 4 unsaved edits"));
  EXPECT_THAT(Kept(), testing::AllOf(testing::HasSubstr("paint"), testing::HasSubstr("branch")));
}

TEST_F(DamagedJournal, AnEditOfSomethingThatIsMissingIsKeptToo) {
  auto project = Open();
  ChangeInstance change{.id = "b"};
  change.set.note = "by the window";
  ASSERT_TRUE(project->Apply(change).ok());
  ASSERT_TRUE(project->Apply(RemoveInstance{"a"}).ok());
  KillHere(std::move(project));
  DamageLine(2);
  project = Open();
  EXPECT_EQ(Ids(*project), "cd");
  EXPECT_THAT(project->warnings()[0], testing::HasSubstr("2 of 6 unsaved edits"));
  EXPECT_THAT(Kept(), testing::HasSubstr("by the window"));
  ASSERT_TRUE(project->Undo().ok());
  EXPECT_EQ(Ids(*project), "acd") << "undo meets the last edit that was repeated";
}

TEST_F(DamagedJournal, UndoAndRedoMeetTheirOwnEditAfterALostOne) {
  auto project = Open();
  ASSERT_TRUE(project->Undo().ok());  // of d
  ASSERT_TRUE(project->Undo().ok());  // of c
  ASSERT_TRUE(project->Redo().ok());  // of c
  KillHere(std::move(project));
  const std::vector<std::string> lines = Lines();
  ASSERT_EQ(lines.size(), 8u);
  const auto ids_without = [&](std::size_t damaged) {
    WriteLines(lines);
    DamageLine(damaged);
    return Ids(*AnnotationProject::Open(file_, AnnotationProject::Access::kRead).value());
  };
  EXPECT_EQ(ids_without(1), "bc");
  EXPECT_EQ(ids_without(3), "abc") << "redo says all of the lost edit";
  EXPECT_EQ(ids_without(4), "abc") << "undo of the lost d takes back nothing else";
  EXPECT_EQ(ids_without(5), "abc") << "a lost undo takes back the edit that was next";
  EXPECT_EQ(ids_without(7), "abc");
  WriteLines(lines);
  DamageLine(4);
  project = Open();
  EXPECT_EQ(project->UndoLabel(), "Add c");
  EXPECT_FALSE(project->RedoLabel().has_value());
}

TEST_F(DamagedJournal, AnyFlippedBitCostsOneEditAtMostOrIsToldWholly) {
  for (std::size_t at = 0; at < journal_.size(); ++at) {
    SCOPED_TRACE("byte " + std::to_string(at));
    std::string damaged = journal_;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    std::ofstream(JournalFile(), std::ios::binary) << damaged;
    const bool header = at <= journal_.find('\n'), end_of_line = journal_[at] == '\n';
    const bool write = at % 40 == 0;
    const auto access =
        write ? AnnotationProject::Access::kWrite : AnnotationProject::Access::kRead;
    const auto project = AnnotationProject::Open(file_, access);
    ASSERT_TRUE(project.ok()) << project.error().message;
    // One edit less and a warning, or nothing: not all of a line matters.
    const std::size_t found = (*project)->document().instances.size();
    const std::size_t warnings = (*project)->warnings().size();
    const std::size_t cost = header ? 4 : end_of_line ? 2 : 1;
    if (warnings == 0) {
      EXPECT_EQ(found, 4u);
    } else {
      EXPECT_EQ(warnings, 1u);
      EXPECT_EQ(found, 4 - cost);
    }
    if (HasFailure()) return;
  }
}

TEST_F(DamagedJournal, OfManyEditsAndUndosTheRestIsTheSameAfterTheNextKill) {
  for (std::uint32_t trial = 0; trial < 20; ++trial) {
    Random random({.seed = trial});
    auto project = Open();
    for (int i = 0; i < 40; ++i) {
      const auto choice = random.Index(4);
      if (choice == 0 && project->UndoLabel()) {
        ASSERT_TRUE(project->Undo().ok());
      } else if (choice == 1 && project->RedoLabel()) {
        ASSERT_TRUE(project->Redo().ok());
      } else {
        ASSERT_TRUE(project->Apply(RandomEdit(project->document(), random)).ok());
      }
    }
    KillHere(std::move(project));
    DamageLine(1 + random.Index(static_cast<std::uint32_t>(Lines().size() - 1)));
    project = Open();
    const std::string text = Text(*project);
    KillHere(std::move(project));
    project = Open();
    EXPECT_EQ(Text(*project), text);
    EXPECT_TRUE(project->warnings().empty());
    while (project->UndoLabel() && project->Undo().ok()) continue;
    ASSERT_TRUE(project->Save().ok());
  }
}

TEST_F(DamagedJournal, LinesThatAreSavedNeedNotBeReadAgain) {
  auto project = Open();
  ASSERT_TRUE(project->Save().ok());
  ASSERT_TRUE(project->Apply(RemoveInstance{"d"}).ok());
  KillHere(std::move(project));
  DamageLine(2);
  project = Open();
  EXPECT_EQ(Ids(*project), "abc");
  EXPECT_TRUE(project->warnings().empty());
}

TEST_F(AnnotationProjectTest, LeavesNoLockBehind) {
  Create().reset();
  EXPECT_FALSE(std::filesystem::exists(file_.string() + ".lock"));
  // One that a kill left is nobody's.
  std::ofstream(file_.string() + ".lock") << "process 1 on elsewhere";
  EXPECT_TRUE(AnnotationProject::Open(file_).ok());
  EXPECT_FALSE(std::filesystem::exists(file_.string() + ".lock"));
}

}  // namespace
}  // namespace plumbline
