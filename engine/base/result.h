// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "engine/base/check.h"

namespace plumbline {

enum class ErrorCode {
  kInvalidInput,
  kNotFound,
  kCorrupt,
  kDegenerate,
  kCancelled,
  kIo,
  kUnsupported
};

/// An expected failure: what was tried, on which file or object, what to do next, in one sentence.
struct Error {
  ErrorCode code = ErrorCode::kInvalidInput;
  std::string message;
};

inline Error InvalidInput(std::string what) { return {ErrorCode::kInvalidInput, std::move(what)}; }

/// A value or an `Error`. Asking for the value of a failure is the caller's bug (ContractError).
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : state_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }
  const Error& error() const {
    PLB_CHECK(!ok()) << "a successful result has no error";
    return std::get<Error>(state_);
  }
  T& value() & {
    PLB_CHECK(ok()) << error().message;
    return std::get<T>(state_);
  }
  const T& value() const& {
    PLB_CHECK(ok()) << error().message;
    return std::get<T>(state_);
  }
  T&& value() && {
    PLB_CHECK(ok()) << error().message;
    return std::get<T>(std::move(state_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  std::variant<T, Error> state_;
};

/// Success or an `Error`.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)
  bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const {
    PLB_CHECK(!ok()) << "a successful status has no error";
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace plumbline
