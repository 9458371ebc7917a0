// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/report_message.h"

#include <gtest/gtest.h>

#include "tests/engine/recording/random_run.h"

namespace plumbline {
namespace {

constexpr int kManyModels = 1 << 16;  ///< As many as a label can name.

/// As it is in a run file.
FrameReport Stored(FrameReport report) {
  report.skip_cause = SkipCause::kUnknown;
  report.landmarks.clear();
  return report;
}

TEST(ReportMessage, KeepsEveryBitThatARunFileKeeps) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const FrameReport report = Stored(RandomFrame(seed, 7, 4, 50));
    wire::Report message;
    ASSERT_TRUE(message.ParseFromString(ReportToWire(report, true).SerializeAsString()));
    const auto back = ReportFromWire(message, kManyModels);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(Fingerprint(*back), Fingerprint(report));
  }
}

TEST(ReportMessage, WithoutParticlesItIsSmall) {
  const FrameReport report = RandomFrame(1, 7, 4, 500);
  const wire::Report message = ReportToWire(report, false);
  EXPECT_LT(message.ByteSizeLong(), ReportToWire(report, true).ByteSizeLong() / 3);
  const auto back = ReportFromWire(message, kManyModels);
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->objects.front().particles, nullptr);
}

TEST(ReportMessage, RefusesLabelsOfModelsThatAreNotThereAndDamagedRecords) {
  const wire::Report whole = ReportToWire(RandomFrame(1, 7, 4, 50), true);
  EXPECT_FALSE(ReportFromWire(whole, 0).ok());
  wire::Report message = whole;
  message.mutable_frame_record()->resize(message.frame_record().size() / 2);
  EXPECT_FALSE(ReportFromWire(message, kManyModels).ok());
  message = whole;
  message.mutable_objects(0)->set_state(9);
  EXPECT_FALSE(ReportFromWire(message, kManyModels).ok());
  message = whole;
  message.mutable_objects(1)->set_particles("none");
  EXPECT_FALSE(ReportFromWire(message, kManyModels).ok());
}

}  // namespace
}  // namespace plumbline
