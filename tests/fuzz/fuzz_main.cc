// SPDX-License-Identifier: Apache-2.0
// One program of libFuzzer for all targets: PLUMBLINE_FUZZ_TARGET names the one to run.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/check.h"
#include "engine/base/log.h"
#include "engine/base/random.h"
#include "tests/fuzz/fuzz_targets.h"
#include "tests/fuzz/mutation.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using plumbline::fuzz::Target;

std::optional<Target> chosen;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  spdlog::set_level(spdlog::level::off);  // a line for each input that is refused tells nobody
  const char* name = std::getenv("PLUMBLINE_FUZZ_TARGET");
  for (const Target& target : plumbline::fuzz::Targets()) {
    if (name == nullptr) std::printf("%s\n", std::string(target.name).c_str());
    if (name != nullptr && target.name == name) chosen = target;
  }
  if (chosen) return 0;
  if (name == nullptr) std::exit(0);  // with the list of names
  std::fprintf(stderr, "PLUMBLINE_FUZZ_TARGET: there is no target '%s'\n", name);
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const plumbline::Status status =
      chosen->run(std::string_view(reinterpret_cast<const char*>(data), size));
  PLB_CHECK(status.ok() || !status.error().message.empty()) << "an error says nothing";
  return 0;
}

/// Half of the time libFuzzer's own mutations, which follow what the program compares with, half of
/// the time ours, which keep the form of the file.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned int seed) {
  plumbline::Random random({.seed = seed});
  if (random.Index(2) == 0) return LLVMFuzzerMutate(data, size, max_size);
  const std::string changed =
      plumbline::fuzz::Mutate(std::string_view(reinterpret_cast<const char*>(data), size), random);
  const std::size_t kept = std::min(changed.size(), max_size);
  std::memcpy(data, changed.data(), kept);
  return kept;
}
