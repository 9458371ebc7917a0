// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/sensor_work.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string_view>

namespace plumbline {
namespace {

constexpr std::string_view kPlay = "play:";
constexpr std::int64_t kTryAgainNs = 1'000'000'000;

}  // namespace

std::int64_t SteadyNs() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

void SensorWork::WaitUntil(std::int64_t time_ns) const {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_until(lock, stop,
                   std::chrono::steady_clock::time_point(std::chrono::nanoseconds(time_ns)),
                   [] { return false; });
}

void SensorWork::WaitToTryAgain() const { WaitUntil(SteadyNs() + kTryAgainNs); }

bool IsPlayed(const std::string& spec) { return spec.starts_with(kPlay); }

Result<std::shared_ptr<const Sequence>> PlayedSequence(const std::string& spec) {
  auto sequence = OpenSequence(spec.substr(kPlay.size()));
  if (!sequence.ok() || (*sequence)->num_frames() > 0) return sequence;
  return Error{ErrorCode::kInvalidInput, "'" + spec + "' has no frames"};
}

}  // namespace plumbline
