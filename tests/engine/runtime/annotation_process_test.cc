// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/annotation_process.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/annotation_scene.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using State = AnnotationSnapshot::State;

class AnnotationProcessTest : public testing::Test {
 protected:
  AnnotationChoice Choice() const {
    AnnotationChoice choice;
    choice.path = scene_.scan;
    return choice;
  }
  static bool WaitFor(const AnnotationProcess& process,
                      const std::function<bool(const AnnotationSnapshot&)>& condition) {
    for (int i = 0; i < 3000; ++i) {
      if (condition(*process.Snapshot())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  TemporaryFolder folder_;
  AnnotationScene scene_ = MakeAnnotationScene(folder_.path());
};

TEST_F(AnnotationProcessTest, LoadsPlacesAndAcceptsOnItsOwnThreads) {
  std::atomic<int> published = 0;
  AnnotationProcess process(Choice(), [&] { ++published; });
  ASSERT_TRUE(WaitFor(process, [](const auto& s) { return s.ready_to_align; }));
  process.Post(PlaceModelCommand{"armchair", scene_.scan_from_armchair.translation()});
  ASSERT_TRUE(WaitFor(process, [](const auto& s) { return s.placement && !s.placement->running; }));
  process.Post(AcceptProposalCommand{});
  ASSERT_TRUE(WaitFor(process, [](const auto& s) { return s.instances.size() == 1; }));
  EXPECT_THAT(process.Snapshot()->instances[0].scan_from_object,
              IsometryNear(scene_.scan_from_armchair, 0.1, 0.002));
  EXPECT_GT(published, 3);
}

TEST_F(AnnotationProcessTest, AnswersWhileItAlignsAndStopsWhenAsked) {
  AnnotationProcess process(Choice(), {});
  ASSERT_TRUE(WaitFor(process, [](const auto& s) { return s.ready_to_align && s.busy.empty(); }));
  process.Post(PlaceModelCommand{"armchair", scene_.scan_from_armchair.translation()});
  process.Post(SetAnnotatorCommand{"Bo"});
  ASSERT_TRUE(WaitFor(process, [](const auto& s) { return s.annotator == "Bo"; }));
  process.Post(CancelProposalCommand{});
  ASSERT_TRUE(WaitFor(process, [](const auto& s) { return !s.placement && s.busy.empty(); }));
}

TEST_F(AnnotationProcessTest, TellsByTheirNumbersWhichCommandsWereCarriedOutOrRefused) {
  AnnotationProcess process(Choice(), {});
  EXPECT_EQ(process.Snapshot()->last_command.number, 0u);
  const std::uint64_t renamed = process.Post(SetAnnotatorCommand{"Bo"}).value();
  const std::uint64_t refused = process.Post(RemoveInstanceCommand{"nobody"}).value();
  EXPECT_EQ(renamed, 1u);
  EXPECT_EQ(refused, 2u);
  ASSERT_TRUE(WaitFor(process, [&](const auto& s) { return s.last_command.number == refused; }));
  EXPECT_NE(process.Snapshot()->last_command.refusal.find("nobody"), std::string::npos);
  const std::uint64_t selected = process.Post(SelectInstanceCommand{}).value();
  ASSERT_TRUE(WaitFor(process, [&](const auto& s) { return s.last_command.number == selected; }));
  EXPECT_EQ(process.Snapshot()->last_command.refusal, "") << "of that command alone";
}

TEST_F(AnnotationProcessTest, FailsWithASentenceAndEndsCleanlyInTheMiddleOfWork) {
  AnnotationChoice nothing;
  nothing.path = folder_.path() / "nothing.ply";
  AnnotationProcess failed(nothing, {});
  ASSERT_TRUE(WaitFor(failed, [](const auto& s) { return s.state == State::kFailed; }));
  EXPECT_NE(failed.Snapshot()->failure.find("nothing.ply"), std::string::npos);
  AnnotationProcess process(Choice(), {});  // destroyed while it loads
}

}  // namespace
}  // namespace plumbline
