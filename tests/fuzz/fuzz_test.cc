// SPDX-License-Identifier: Apache-2.0
// The quick mode of the fuzzer: every seed, and some mutations of each, always the same ones.
#include "tests/fuzz/fuzz_targets.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/files.h"
#include "engine/base/random.h"
#include "tests/fuzz/mutation.h"
#include "tests/fuzz/packed_files.h"
#include "tests/support/test_data.h"

namespace plumbline::fuzz {
namespace {

constexpr int kMutations = 150;  ///< Of each target: all of them together take a few seconds.
/// Far more than the second that an input may take: tests run on busy machines.
constexpr std::chrono::seconds kHang{10};

std::filesystem::path SeedsFolder() { return SourceDirectory() / "tests/fuzz/seeds"; }

std::vector<std::filesystem::path> SeedsOf(const Target& target) {
  std::vector<std::filesystem::path> seeds;
  const auto folder = SeedsFolder() / target.name;
  if (!std::filesystem::exists(folder)) return seeds;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    seeds.push_back(entry.path());
  std::sort(seeds.begin(), seeds.end());
  return seeds;
}

bool IsRegression(const std::filesystem::path& seed) {
  return seed.filename().string().starts_with("regression_");
}

/// Runs the target; what it should not have done fails the test. The input that does it stays in
/// the folder of tests.
Status RunChecked(const Target& target, const std::string& input) {
  const auto kept = std::filesystem::temp_directory_path() /
                    ("plumbline_fuzz_" + std::string(target.name) + ".input");
  EXPECT_TRUE(WriteFileAtomically(kept, input).ok());
  const auto begin = std::chrono::steady_clock::now();
  Status status;
  EXPECT_NO_THROW(status = target.run(input)) << "the input is " << kept;
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kHang) << "the input is " << kept;
  EXPECT_TRUE(status.ok() || !status.error().message.empty()) << "the input is " << kept;
  if (!testing::Test::HasFailure()) std::filesystem::remove(kept);
  return status;
}

class Fuzz : public testing::TestWithParam<Target> {};

TEST_P(Fuzz, SeedsAreReadAndRegressionsEndInASentence) {
  const auto seeds = SeedsOf(GetParam());
  EXPECT_FALSE(std::all_of(seeds.begin(), seeds.end(), IsRegression)) << "it has no seed";
  for (const auto& seed : seeds) {
    SCOPED_TRACE(seed.string());
    const Status status = RunChecked(GetParam(), ReadFile(seed).value());
    if (IsRegression(seed)) continue;
    EXPECT_TRUE(status.ok()) << (status.ok() ? "" : status.error().message);
  }
}

TEST_P(Fuzz, MutationsAreReadOrRefused) {
  static const std::set<std::string_view> kByAssimp = {"obj", "gltf", "collada"};
  if (kByAssimp.contains(GetParam().name)) GTEST_SKIP() << "assimp itself may end the program";
  const auto seeds = SeedsOf(GetParam());
  ASSERT_FALSE(seeds.empty());
  for (int i = 0; i < kMutations && !HasFailure(); ++i) {
    const auto& seed = seeds[static_cast<std::size_t>(i) % seeds.size()];
    SCOPED_TRACE(seed.string() + ", mutation " + std::to_string(i));
    Random random({.seed = 16, .frame = static_cast<std::uint32_t>(i)});
    (void)RunChecked(GetParam(), Mutate(ReadFile(seed).value(), random));
  }
}

INSTANTIATE_TEST_SUITE_P(Readers, Fuzz, testing::ValuesIn(Targets()),
                         [](const auto& target) { return std::string(target.param.name); });

TEST(FuzzTargets, HaveTheirSeedsAndTheirRowOfTheReadme) {
  std::set<std::string> targets, folders, rows;
  for (const Target& target : Targets()) targets.insert(std::string(target.name));
#ifndef PLUMBLINE_FUZZ_PANELS
  targets.insert("panel_states");
#endif
  for (const auto& entry : std::filesystem::directory_iterator(SeedsFolder()))
    folders.insert(entry.path().filename().string());
  EXPECT_EQ(folders, targets);
  static const std::regex kRow(R"(\n\| (`[^|]+`) \|)"), kName("`([a-z_0-9]+)`");
  const std::string readme = ReadFile(SourceDirectory() / "tests/fuzz/README.md").value();
  for (std::sregex_iterator row(readme.begin(), readme.end(), kRow), end; row != end; ++row) {
    const std::string names = (*row)[1];
    for (std::sregex_iterator name(names.begin(), names.end(), kName); name != end; ++name)
      rows.insert((*name)[1]);
  }
  EXPECT_EQ(rows, targets);
}

/// A new reader of files must be fed here, or be one of these, which a target reaches by others.
TEST(FuzzTargets, FeedEveryReaderOfAFile) {
  static const std::set<std::string> kReached = {
      "ReadFile",                // by nearly all
      "ReadStampedRows",         // imu, tracks, covariances, reference_states
      "ReadByAssimp",            // obj, gltf, collada
      "ReadCandidates",          // run_file, exported_map
      "ReadSmoothedCandidates",  // run_file, exported_map
      "ReadGroundTruthPoses",    // ground_truth
      "ReadNetworkSidecar",      // network_sidecar
      "ReadAnnotationScan"};     // ply, pcd
  static const std::regex kReader(R"(Result<[^;{]*>\s+(Read\w+)\(\s*const std::filesystem::path&)");
  std::string targets;
  for (const auto& entry : std::filesystem::directory_iterator(SourceDirectory() / "tests/fuzz")) {
    if (entry.path().string().ends_with("_targets.cc")) targets += ReadFile(entry.path()).value();
  }
  int readers = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(SourceDirectory() / "engine")) {
    if (entry.path().extension() != ".h") continue;
    const std::string header = ReadFile(entry.path()).value();
    for (std::sregex_iterator match(header.begin(), header.end(), kReader), end; match != end;
         ++match, ++readers) {
      const std::string name = (*match)[1];
      EXPECT_TRUE(kReached.contains(name) || targets.find(name + "(") != std::string::npos)
          << name << " of " << entry.path() << " has no target (CONTRIBUTING.md, how to add)";
    }
  }
  EXPECT_GT(readers, 20);
}

TEST(PackedFiles, AreTakenApartAndPutTogether) {
  const std::string text = "==> a.json <==\n{}\n==> b/c.csv <==\n1,2\n";
  const auto files = SplitFiles(text);
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].name, "a.json");
  EXPECT_EQ(files[1].content, "1,2\n");
  EXPECT_EQ(JoinFiles(files), text);
}

TEST(PackedFiles, StayInTheirFolder) {
  EXPECT_TRUE(SplitFiles("==> ../a <==\nx\n==> /a <==\nx\n==> b/../../c <==\n").empty());
}

TEST(Mutations, AreTheSameEachTimeAndOtherThanTheInput) {
  const std::string input = "{\"a\": [1, 2, 3], \"b\": {\"c\": \"text\"}}";
  int same = 0;
  for (std::uint32_t i = 0; i < 100; ++i) {
    Random one({.seed = 1, .frame = i}), two({.seed = 1, .frame = i});
    const std::string changed = Mutate(input, one);
    EXPECT_EQ(changed, Mutate(input, two));
    same += changed == input;
  }
  EXPECT_LT(same, 10);  // a value may be replaced by itself
}

}  // namespace
}  // namespace plumbline::fuzz
