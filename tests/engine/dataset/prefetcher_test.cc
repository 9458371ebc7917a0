// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/prefetcher.h"

#include <algorithm>
#include <atomic>
#include <chrono>

#include <gmock/gmock.h>

#include "engine/base/check.h"
#include "engine/base/random.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

/// A sequence that knows how many of its images somebody else still holds.
class WatchedSequence : public Sequence {
 public:
  explicit WatchedSequence(std::shared_ptr<const Sequence> inner) : inner_(std::move(inner)) {}

  int MostAlive() const { return most_alive_; }
  int reads() const { return reads_; }
  std::chrono::milliseconds delay{0};
  int throws_at = -1;

  const std::filesystem::path& path() const override { return inner_->path(); }
  int num_frames() const override { return inner_->num_frames(); }
  const PinholeCamera& camera() const override { return inner_->camera(); }
  double rate_hz() const override { return inner_->rate_hz(); }
  std::int64_t stamp_ns(int index) const override { return inner_->stamp_ns(index); }
  std::optional<Eigen::Isometry3d> world_from_cam(int index) const override {
    return inner_->world_from_cam(index);
  }
  std::optional<Eigen::Vector3d> gravity_in_world() const override {
    return inner_->gravity_in_world();
  }
  std::optional<Eigen::Vector4d> floor_in_world() const override {
    return inner_->floor_in_world();
  }
  Result<Frame> ReadFrame(int index) const override {
    if (index == throws_at) throw std::bad_alloc();
    std::this_thread::sleep_for(delay);
    Result<Frame> frame = inner_->ReadFrame(index);
    ++reads_;
    if (frame.ok()) {
      const std::lock_guard lock(mutex_);
      std::erase_if(images_, [](const cv::Mat& image) { return image.u->refcount == 1; });
      images_.push_back(frame->image);
      most_alive_ = std::max(most_alive_.load(), static_cast<int>(images_.size()));
    }
    return frame;
  }
  Result<std::optional<EdgeMap>> ReadEdges(int index) const override {
    return inner_->ReadEdges(index);
  }
  Result<std::optional<std::vector<Detection>>> ReadProposals(int index) const override {
    return inner_->ReadProposals(index);
  }
  bool has_edges() const override { return false; }
  bool has_proposals() const override { return false; }
  std::optional<std::filesystem::path> scene_file() const override { return {}; }
  std::optional<std::filesystem::path> ground_truth_file() const override { return {}; }
  std::optional<std::filesystem::path> models_folder() const override { return {}; }
  const std::vector<std::string>& warnings() const override { return inner_->warnings(); }

 private:
  std::shared_ptr<const Sequence> inner_;
  mutable std::mutex mutex_;
  mutable std::vector<cv::Mat> images_;
  mutable std::atomic<int> most_alive_ = 0;
  mutable std::atomic<int> reads_ = 0;
};

class Prefetching : public testing::Test {
 protected:
  void Open(int frames) {
    WriteTinySequence(folder_.path(), {.frames = frames});
    watched_ = std::make_shared<WatchedSequence>(OpenSequence(folder_.path()).value());
  }
  TemporaryFolder folder_;
  std::shared_ptr<WatchedSequence> watched_;
};

TEST_F(Prefetching, GivesEveryFrameOnceInOrderInBoundedMemory) {
  Open(300);
  FramePrefetcher prefetcher(watched_, 1, 4);
  for (int i = 0; i < 300; ++i) {
    const Result<Frame> frame = prefetcher.Get(i);
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_EQ(frame->index, i);
    EXPECT_EQ(frame->stamp_ns, i * 100000000ll);
  }
  EXPECT_EQ(watched_->reads(), 300);
  // Four ahead, the one given last, the one in the reader's hand, the one in the thread's.
  EXPECT_LE(watched_->MostAlive(), 7);
}

TEST_F(Prefetching, GivesTheRightFrameAfterAnyJump) {
  Open(40);
  FramePrefetcher prefetcher(watched_, 1, 3);
  Random random({.seed = 11});
  int index = 0;
  for (int i = 0; i < 200; ++i) {
    index = random.Uniform() < 0.5 ? static_cast<int>(random.Index(40)) : std::min(39, index + 1);
    ASSERT_EQ(prefetcher.Get(index).value().index, index);
  }
  EXPECT_EQ(prefetcher.Get(39).value().index, 39);
  EXPECT_EQ(prefetcher.Get(39).value().index, 39);
  EXPECT_LE(watched_->MostAlive(), 6);
}

TEST_F(Prefetching, StepsForwardsAndBackwards) {
  Open(20);
  FramePrefetcher every_third(watched_, 3, 2);
  for (int i = 1; i < 20; i += 3) EXPECT_EQ(every_third.Get(i).value().index, i);
  FramePrefetcher backwards(watched_, -1, 2);
  for (int i = 19; i >= 0; --i) EXPECT_EQ(backwards.Get(i).value().index, i);
}

TEST_F(Prefetching, HandsOnTheErrorsOfFramesAndGoesOn) {
  Open(6);
  WriteText(folder_.path() / "color/000002.jpg", "no image");
  watched_->throws_at = 4;
  FramePrefetcher prefetcher(watched_);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(prefetcher.Get(i).ok(), i != 2 && i != 4) << i;
}

TEST_F(Prefetching, StopsWaitingWhenAsked) {
  Open(3);
  watched_->delay = std::chrono::milliseconds(50);
  FramePrefetcher prefetcher(watched_);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(prefetcher.Get(2, stop.get_token()).error().code, ErrorCode::kCancelled);
  EXPECT_EQ(prefetcher.Get(2).value().index, 2);
}

TEST_F(Prefetching, EndsCleanlyWhateverItIsDoing) {
  Open(5);
  watched_->delay = std::chrono::milliseconds(2);
  for (int i = 0; i < 20; ++i) {
    FramePrefetcher prefetcher(watched_);
    if (i % 2 == 0) {
      EXPECT_TRUE(prefetcher.Get(i % 5).ok());
    }
  }
}

TEST_F(Prefetching, RefusesFramesThatThereAreNot) {
  Open(2);
  FramePrefetcher prefetcher(watched_);
  EXPECT_THROW(static_cast<void>(prefetcher.Get(2)), ContractError);
  EXPECT_THROW(FramePrefetcher(watched_, 0), ContractError);
}

}  // namespace
}  // namespace plumbline
