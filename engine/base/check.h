// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace plumbline {

/// A broken invariant or a caller's bug. Caught at process boundaries and in `main` only.
class ContractError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

namespace internal {
class CheckFailure {
 public:
  CheckFailure(const char* condition, const char* file, int line) {
    stream_ << file << ":" << line << ": check failed: " << condition << " ";
  }
  CheckFailure(const CheckFailure&) = delete;
  CheckFailure& operator=(const CheckFailure&) = delete;
  [[noreturn]] ~CheckFailure() noexcept(false) { throw ContractError(stream_.str()); }
  std::ostream& stream() { return stream_; }

 private:
  std::ostringstream stream_;
};
struct CheckVoid {
  void operator&(std::ostream&) const {}
};
}  // namespace internal
}  // namespace plumbline

#define PLB_CHECK(condition)                         \
  (condition) ? (void)0                              \
              : ::plumbline::internal::CheckVoid() & \
                    ::plumbline::internal::CheckFailure(#condition, __FILE__, __LINE__).stream()
