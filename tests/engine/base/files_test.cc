// SPDX-License-Identifier: Apache-2.0
#include "engine/base/files.h"

#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/json_text.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

int NumFiles(const std::filesystem::path& folder) {
  return static_cast<int>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(WriteFileAtomically, ReplacesTheWholeFileAndLeavesNothingBeside) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.txt";
  ASSERT_TRUE(WriteFileAtomically(file, "a rather long first content").ok());
  ASSERT_TRUE(WriteFileAtomically(file, std::string("zero\0inside", 11)).ok());
  EXPECT_EQ(ReadFile(file).value(), std::string("zero\0inside", 11));
  EXPECT_EQ(NumFiles(folder.path()), 1);
}

TEST(WriteFileAtomically, KeepsTheOldFileWhenItFails) {
  const TemporaryFolder folder;
  const std::filesystem::path target = folder.path() / "a.txt";
  std::filesystem::create_directories(target / "in the way");  // a rename onto this must fail
  const Status status = WriteFileAtomically(target, "new");
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kIo);
  EXPECT_THAT(status.error().message, HasSubstr(target.string()));
  EXPECT_TRUE(std::filesystem::is_directory(target / "in the way"));
  EXPECT_EQ(NumFiles(folder.path()), 1) << "the temporary file stays behind";
}

TEST(WriteFileAtomically, NamesTheFileWhoseFolderIsMissing) {
  const TemporaryFolder folder;
  const Status status = WriteFileAtomically(folder.path() / "missing" / "a.txt", "x");
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, AllOf(HasSubstr("missing/a.txt"), HasSubstr("No such file")));
}

TEST(WriteFileAtomically, KilledInTheMiddleItLeavesTheOldFileAndNothingBeside) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.txt";
  ASSERT_TRUE(WriteFileAtomically(file, "old").ok());
  const pid_t child = fork();
  if (child == 0) {  // the system ends it at the first byte beyond the limit
    rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
    limit = {0, 0};
    setrlimit(RLIMIT_CORE, &limit);
    signal(SIGXFSZ, SIG_DFL);
    _exit(WriteFileAtomically(file, std::string(1'000'000, 'x')).ok() ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(ReadFile(file).value(), "old");
  EXPECT_EQ(NumFiles(folder.path()), 1);
}

TEST(ReadFile, NamesWhatIsMissingOrAFolder) {
  const TemporaryFolder folder;
  EXPECT_EQ(ReadFile(folder.path() / "no.txt").error().code, ErrorCode::kNotFound);
  EXPECT_THAT(ReadFile(folder.path() / "no.txt").error().message, HasSubstr("no.txt"));
  EXPECT_EQ(ReadFile(folder.path()).error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(ReadFile(folder.path()).error().message, HasSubstr("folder"));
}

TEST(ReadFile, RefusesWhatNeedNeverEnd) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::filesystem::path& path : {pipe, std::filesystem::path("/dev/zero")}) {
    const Result<std::string> read = ReadFile(path);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().code, ErrorCode::kInvalidInput);
    EXPECT_THAT(read.error().message, HasSubstr("a file is needed"));
  }
}

TEST(WriteFileAtomically, RemovesWhatKilledProcessesLeftLongAgoAndNothingElse) {
  const TemporaryFolder folder;
  const pid_t gone = ::fork();
  if (gone == 0) ::_exit(0);
  ASSERT_EQ(::waitpid(gone, nullptr, 0), gone);
  const std::string of_gone = ".tmp" + std::to_string(gone) + "-0";
  const std::string of_us = ".tmp" + std::to_string(::getpid()) + "-77";
  const auto long_ago = std::filesystem::file_time_type::clock::now() - std::chrono::hours(1);
  for (const std::string& name :
       {"a" + of_gone, "a" + of_us, "b" + of_gone, std::string("a.tmp")}) {
    std::ofstream(folder.path() / name) << "part";
    std::filesystem::last_write_time(folder.path() / name, long_ago);
  }
  std::ofstream(folder.path() / ("young" + of_gone)) << "part";
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "a", "whole").ok());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / ("a" + of_gone)));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / ("a" + of_us))) << "it is being written";
  EXPECT_FALSE(std::filesystem::exists(folder.path() / ("b" + of_gone)));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / ("young" + of_gone)))
      << "another machine may be writing it";
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "a.tmp"));
}

TEST(ReadFile, ReportsAFileThatItMayNotRead) {
  if (geteuid() == 0) GTEST_SKIP() << "root may read every file";
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "secret.txt";
  ASSERT_TRUE(WriteFileAtomically(file, "x").ok());
  std::filesystem::permissions(file, std::filesystem::perms::none);
  const Result<std::string> content = ReadFile(file);
  ASSERT_FALSE(content.ok());
  EXPECT_THAT(content.error().message, HasSubstr("secret.txt"));
}

TEST(ReadJson, AllowsComments) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "a.json")
      << "// first\n{\"a\": 1, /* inside */ \"b\": [2, 3]} // last\n";
  EXPECT_EQ(ReadJson(folder.path() / "a.json").value(), (nlohmann::json{{"a", 1}, {"b", {2, 3}}}));
}

TEST(ReadJson, NamesFileAndLineOfAMistake) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "bad.json") << "{\"a\": 1,\n \"b\": }\n";
  const Result<nlohmann::json> json = ReadJson(folder.path() / "bad.json");
  ASSERT_FALSE(json.ok());
  EXPECT_EQ(json.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(json.error().message, AllOf(HasSubstr("bad.json"), HasSubstr("line 2")));
}

/// Each level that a value is copied through takes some of the stack: these ended the program.
TEST(ReadJson, RefusesNestingThatTheStackCannotHold) {
  TemporaryFolder folder;
  const std::size_t levels = 200000;
  for (const std::string& text :
       {std::string(levels, '[') + std::string(levels, ']'), std::string(levels, '['),
        "{\"a\": \"]\\\"\", \"b\": " + std::string(levels, '[')}) {
    std::ofstream(folder.path() / "deep.json") << text;
    const Result<nlohmann::json> json = ReadJson(folder.path() / "deep.json");
    ASSERT_FALSE(json.ok());
    EXPECT_THAT(json.error().message, HasSubstr("more than 200 levels"));
    EXPECT_TRUE(ParseJson(text).is_discarded());
  }
}

TEST(ReadJson, DoesNotCountBracketsInTextsAndComments) {
  TemporaryFolder folder;
  const std::string brackets(1000, '[');
  std::ofstream(folder.path() / "a.json")
      << "// " << brackets << "\n{\"a\": \"" << brackets << "\\\"\" /* " << brackets << " */}";
  EXPECT_EQ(ReadJson(folder.path() / "a.json").value().at("a"), brackets + "\"");
}

TEST(ReadJson, RefusesATruncatedFile) {
  const TemporaryFolder folder;
  for (const char* text : {"", "{\"a\": [1, 2", "{\"a\": 1} {"}) {
    std::ofstream(folder.path() / "cut.json") << text;
    EXPECT_EQ(ReadJson(folder.path() / "cut.json").error().code, ErrorCode::kCorrupt) << text;
  }
}

TEST(WriteJson, IsReadBackTheSame) {
  const TemporaryFolder folder;
  const nlohmann::json json = {{"pi", 3.141592653589793}, {"name", "\u00fcber"}, {"none", nullptr}};
  ASSERT_TRUE(WriteJson(folder.path() / "a.json", json).ok());
  EXPECT_EQ(ReadJson(folder.path() / "a.json").value(), json);
}

TEST(WriteJson, ReplacesWhatIsNotUtf8) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteJson(folder.path() / "a.json", {{"path", "caf\xe9/chair"}}).ok());
  EXPECT_EQ(ReadJson(folder.path() / "a.json").value().at("path"), "caf\xef\xbf\xbd/chair");
}

TEST(Hash, IsXxh3AndTheSameForAFile) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "empty", "").ok());
  EXPECT_EQ(HashHex(""),
            "2d06800538d394c2");  // XXH3_64bits of nothing, seed 0, as its specification gives it
  EXPECT_EQ(HashFile(folder.path() / "empty").value(), HashHex(""));
  EXPECT_NE(HashHex("a"), HashHex("b"));
  EXPECT_FALSE(HashFile(folder.path() / "missing").ok());
}

TEST(CacheDirectory, FollowsTheEnvironmentAndExists) {
  const TemporaryFolder folder;
  const char* before = std::getenv("XDG_CACHE_HOME");
  const std::string kept = before != nullptr ? before : "";
  setenv("XDG_CACHE_HOME", folder.path().c_str(), 1);
  EXPECT_EQ(CacheDirectory(), folder.path() / "plumbline");
  EXPECT_TRUE(std::filesystem::is_directory(folder.path() / "plumbline"));
  if (before != nullptr) {
    setenv("XDG_CACHE_HOME", kept.c_str(), 1);
  } else {
    unsetenv("XDG_CACHE_HOME");
  }
}

TEST(JsonNumbers, AreWholeAndFit) {
  EXPECT_EQ(IntFromJson(nlohmann::json::parse("-2147483648")), -2147483648);
  EXPECT_EQ(IntFromJson(7), 7);
  EXPECT_EQ(UnsignedFromJson(nlohmann::json::parse("18446744073709551615")), 18446744073709551615u);
  for (const char* wrong :
       {"2147483648", "-2147483649", "18446744073709551615", "4e200", "1.5", "\"1\"", "null"}) {
    EXPECT_THROW(IntFromJson(nlohmann::json::parse(wrong)), std::range_error) << wrong;
  }
  for (const char* wrong : {"-1", "4e200", "1.5", "[]"})
    EXPECT_THROW(UnsignedFromJson(nlohmann::json::parse(wrong)), std::range_error) << wrong;
}

}  // namespace
}  // namespace plumbline
