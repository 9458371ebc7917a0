// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.h"

namespace plumbline {

/// Where a node listens: ipc://FILE, or tcp://HOST:PORT with a numeric or a host's name.
class Endpoint {
 public:
  /// Errors: kInvalidInput, with how it must be written.
  static Result<Endpoint> Parse(std::string_view text);

  /// As ZeroMQ takes it.
  const std::string& text() const { return text_; }
  /// Whether nobody but programs of this machine can reach it: ipc, 127.0.0.0/8, [::1], localhost.
  bool is_local() const { return local_; }

 private:
  Endpoint(std::string text, bool local) : text_(std::move(text)), local_(local) {}
  std::string text_;
  bool local_;
};

}  // namespace plumbline
