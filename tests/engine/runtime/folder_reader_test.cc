// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/folder_reader.h"

#include <filesystem>
#include <fstream>
#include <future>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/test_data.h"

namespace plumbline {
namespace {

bool Never() { return false; }

TEST(FolderReader, ListsFoldersFirstAndSaysWhatEachIs) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "walk" / "color");
  std::ofstream(folder.path() / "walk" / "camera.json") << "{}";
  std::filesystem::create_directories(folder.path() / "Empty");
  std::ofstream(folder.path() / "run.PLB") << "12345";
  std::ofstream(folder.path() / "a.annotation.json") << R"({"plumbline_annotation": 1})";
  std::ofstream(folder.path() / "b.json") << "{}";
  std::filesystem::create_symlink("nowhere", folder.path() / "broken");
  const FolderView view = ReadFolder(folder.path(), Never);
  ASSERT_EQ(view.problem, "");
  std::vector<std::string> names;
  std::vector<PathKind> kinds;
  for (const FolderEntry& entry : view.entries) {
    names.push_back(entry.name);
    kinds.push_back(entry.kind);
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{"Empty", "walk", "a.annotation.json", "b.json", "run.PLB"}));
  EXPECT_EQ(kinds, (std::vector<PathKind>{PathKind::kFolder, PathKind::kSequence,
                                          PathKind::kProject, PathKind::kOther, PathKind::kRun}));
  EXPECT_EQ(view.entries.back().size_bytes, 5u);
  EXPECT_GT(view.entries.back().changed_s, 1'600'000'000);
}

TEST(FolderReader, FilesThatHoldASequenceAreSequences) {
  const TemporaryFolder folder;
  for (const char* name : {"a.bag", "scene0000_00.sens"})
    std::ofstream(folder.path() / name) << "x";
  for (const FolderEntry& entry : ReadFolder(folder.path(), Never).entries)
    EXPECT_EQ(entry.kind, PathKind::kSequence) << entry.name;
}

TEST(FolderReader, SaysInOneSentenceWhyAFolderCannotBeRead) {
  const TemporaryFolder folder;
  const std::string missing = (folder.path() / "missing").string();
  EXPECT_EQ(ReadFolder(missing, Never).problem, "There is no folder " + missing + ".");
  std::ofstream(folder.path() / "file") << "x";
  EXPECT_NE(ReadFolder(folder.path() / "file", Never).problem.find("cannot be read"),
            std::string::npos);
}

TEST(FolderReader, PublishesWhatWasAskedForLast) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "b");
  std::promise<void> published;
  std::string wanted = (folder.path() / "b").string();
  FolderReader* reader_of_callback = nullptr;
  bool told = false;
  FolderReader reader([&] {
    if (told || reader_of_callback->View()->folder != wanted) return;
    told = true;
    published.set_value();
  });
  reader_of_callback = &reader;
  for (int i = 0; i < 20; ++i) reader.Read(folder.path());
  reader.Read(wanted);
  published.get_future().wait();
  EXPECT_EQ(reader.View()->folder, wanted);
}

}  // namespace
}  // namespace plumbline
