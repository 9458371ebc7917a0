// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/live_source.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <iterator>

#include "engine/base/check.h"

namespace plumbline {
namespace {

constexpr double kLongest_ns = 1e17;  ///< Three years: further apart, stamps are nonsense.

class MachineClock : public LiveClock {
 public:
  std::int64_t NowNs() const override { return Clock::now().time_since_epoch() / kNs; }
  void WaitUntil(std::int64_t time_ns, const std::stop_token& stop) override {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, stop, Clock::time_point(time_ns * kNs), [] { return false; });
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::nanoseconds kNs{1};
  std::mutex mutex_;
  std::condition_variable_any changed_;  ///< Only `stop` ever wakes it.
};

/// A mean over `count` values, the newest of which is `value`.
void AddToMean(double value, int count, double& mean) { mean += (value - mean) / count; }

}  // namespace

std::shared_ptr<LiveClock> SteadyLiveClock() { return std::make_shared<MachineClock>(); }

LiveSource::LiveSource(FrameSource& recorded, double speed, std::shared_ptr<LiveClock> clock)
    : recorded_(recorded), speed_(speed), clock_(std::move(clock)) {
  PLB_CHECK(speed > 0) << "speed " << speed;
  report_.speed = speed;
}

LiveSource::LiveSource(FrameSource& recorded, const GrowingRecording& growing, int step)
    : recorded_(recorded), growing_(&growing), step_(step), speed_(1), clock_(SteadyLiveClock()) {}

Result<std::optional<Packet>> LiveSource::Next(const std::stop_token& stop) {
  while (ready_.empty()) {
    if (!read_) read_ = Read(stop);
    if (read_->comes_ns) {
      clock_->WaitUntil(*read_->comes_ns, stop);
      if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
      Stretch newest = std::move(*read_);
      for (read_ = ReadWhatCame(stop);
           read_ && read_->comes_ns && *read_->comes_ns <= clock_->NowNs();
           read_ = ReadWhatCame(stop)) {
        PassOver(std::exchange(newest, std::move(*read_)), newest);
      }
      Take(std::move(newest));
    } else if (!read_->packets.empty()) {
      ready_ = std::exchange(read_->packets, {});
    } else if (read_->error) {
      return *read_->error;
    } else {
      return std::optional<Packet>();
    }
  }
  std::optional<Packet> packet = std::move(ready_.front());
  ready_.pop_front();
  return packet;
}

LiveSource::Stretch LiveSource::Read(const std::stop_token& stop) {
  Stretch stretch;
  while (!stretch.comes_ns) {
    Result<std::optional<Packet>> packet = recorded_.Next(stop);
    if (!packet.ok()) stretch.error = packet.error();
    if (!packet.ok() || !packet.value()) break;
    if (const auto* frame = std::get_if<FramePacket>(&**packet)) stretch.comes_ns = ComesAt(*frame);
    stretch.packets.push_back(std::move(**packet));
  }
  return stretch;
}

std::optional<LiveSource::Stretch> LiveSource::ReadWhatCame(const std::stop_token& stop) {
  if (growing_ != nullptr && !growing_->HasFrame(last_read_ + step_)) return std::nullopt;
  return Read(stop);
}

std::int64_t LiveSource::ComesAt(const FramePacket& frame) {
  last_read_ = frame.frame;
  if (!first_stamp_ns_) {
    first_stamp_ns_ = frame.stamp_ns;
    start_ns_ = newest_ns_ = clock_->NowNs();
  }
  if (growing_ != nullptr) return growing_->CameNs(frame.frame);  // in the past
  const double after_ns =
      (static_cast<double>(frame.stamp_ns) - static_cast<double>(*first_stamp_ns_)) / speed_;
  const std::int64_t comes_ns = start_ns_ + std::llround(std::clamp(after_ns, 0.0, kLongest_ns));
  newest_ns_ = std::max(newest_ns_, comes_ns);
  return newest_ns_;
}

void LiveSource::PassOver(Stretch older, Stretch& newer) {
  older.packets.pop_back();  // the frame
  newer.packets.insert(newer.packets.begin(), std::make_move_iterator(older.packets.begin()),
                       std::make_move_iterator(older.packets.end()));
  const std::lock_guard lock(mutex_);
  ++report_.passed_over;
}

void LiveSource::Take(Stretch newest) {
  const auto& frame = std::get<FramePacket>(newest.packets.back());
  const std::int64_t comes_ns = *newest.comes_ns;
  {
    const std::lock_guard lock(mutex_);
    at_work_.emplace_back(frame.frame, comes_ns);
    report_.recorded_s =
        1e-9 * (growing_ != nullptr ? static_cast<double>(frame.stamp_ns - *first_stamp_ns_)
                                    : static_cast<double>(comes_ns - start_ns_) * speed_);
    AddToMean(1e-6 * static_cast<double>(clock_->NowNs() - comes_ns), ++report_.taken,
              report_.taken_age_ms);
  }
  ready_ = std::move(newest.packets);
}

void LiveSource::Done(int frame) {
  const std::int64_t now_ns = clock_->NowNs();
  const std::lock_guard lock(mutex_);
  while (!at_work_.empty() && at_work_.front().first <= frame) {
    AddToMean(1e-6 * static_cast<double>(now_ns - at_work_.front().second), ++report_.done,
              report_.done_age_ms);
    at_work_.pop_front();
  }
}

LiveReport LiveSource::report() const {
  const std::lock_guard lock(mutex_);
  return report_;
}

}  // namespace plumbline
