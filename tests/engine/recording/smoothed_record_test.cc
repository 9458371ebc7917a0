// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/smoothed_record.h"

#include <gtest/gtest.h>

#include "engine/recording/run_summary.h"
#include "tests/engine/recording/random_run.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

class SmoothedRecord : public testing::Test {
 protected:
  SmoothedRecord() {
    const auto writer = RunWriter::Create(file_, RandomHeader(1)).value();
    for (int frame = 0; frame < 5; ++frame) (void)writer->Write(RandomFrame(1, frame, 3, 20), {});
    (void)writer->Close();
  }
  /// Like the objects of a frame, whose numbers are of every kind.
  static SmoothedMap RandomMap() {
    SmoothedMap map{4, 17, 2, 0.1 / 3, 1e-3 / 7, {}};
    for (ObjectReport& report : RandomFrame(2, 0, 3, -1).objects) {
      report.modes.resize(std::max<std::size_t>(1, report.modes.size()));
      report.updated = true;
      report.state = map.objects.empty() ? ObjectState::kConfirmed : ObjectState::kTentative;
      map.objects.push_back({std::move(report), 3, 30, 12, 16, true, 1.0 / 3, 0.01});
    }
    return map;
  }
  static std::string Bits(const SmoothedMap& map) {
    FrameReport frame;
    std::string text;
    for (const SmoothedObject& object : map.objects) {
      frame.objects.push_back(object.belief);
      text += std::to_string(object.looks) + " " + std::to_string(object.looks_before) + " " +
              std::to_string(object.views) + " " + std::to_string(object.agreement) + "\n";
    }
    return Fingerprint(frame) + text;
  }
  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "run.plb";
};

TEST_F(SmoothedRecord, GivesBackTheMapBitForBitAndLeavesTheRun) {
  EXPECT_FALSE(ReadSmoothed(file_).value()) << "a run that has not been smoothed, old or new";
  const std::string before = Fingerprint(RunReader::Open(file_).value()->LastFrame().value());
  const auto estimates = ReadEstimates(file_).value();
  const SmoothedMap map = RandomMap();
  ASSERT_TRUE(WriteSmoothed(file_, map).ok());
  ASSERT_TRUE(WriteSmoothed(file_, map).ok()) << "smoothed again, it is replaced";
  const SmoothedMap read = ReadSmoothed(file_).value().value();
  EXPECT_EQ(Bits(read), Bits(map));
  EXPECT_EQ(read.floor_height_m, map.floor_height_m);
  EXPECT_EQ(read.looks, 17);
  EXPECT_EQ(Fingerprint(RunReader::Open(file_).value()->LastFrame().value()), before);
  EXPECT_EQ(ReadEstimates(file_).value().size(), estimates.size());
  EXPECT_EQ(ReadSmoothedEstimates(file_).value().value().size(), 1u);
}

TEST_F(SmoothedRecord, IsGoneWhenTheRunGoesOn) {
  ASSERT_TRUE(WriteSmoothed(file_, RandomMap()).ok());
  {
    const auto resumed = RunWriter::OpenToResume(file_, RandomHeader(1)).value();
    EXPECT_EQ(WriteSmoothed(file_, RandomMap()).error().code, ErrorCode::kInvalidInput)
        << "somebody is writing the run";
    ASSERT_TRUE(resumed.writer->Close().ok());
  }
  EXPECT_FALSE(ReadSmoothed(file_).value());
  EXPECT_EQ(WriteSmoothed(folder_.path() / "none.plb", {}).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace plumbline
