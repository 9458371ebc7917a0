// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

#include "engine/base/result.h"
#include "engine/transport/plumbline.pb.h"

namespace plumbline {

/// Of the schema; a message of another one is refused.
inline constexpr unsigned kWireVersion = 1;
/// A request that is larger is refused: 200 000 boxes to be scored fit.
inline constexpr std::size_t kMostRequestBytes = std::size_t{4} << 20;

/// What is wrong with a message.
enum class MessageFault { kNone, kMalformed, kVersion, kSize };

struct ParsedRequest {
  wire::Request request;  ///< Its id is also known of one that is refused for its version.
  MessageFault fault = MessageFault::kNone;
  std::string sentence;  ///< Of the fault.
};

/// A request of bytes that nobody vouches for.
ParsedRequest ParseRequest(std::string_view bytes);

/// A reply, likewise. Errors: kCorrupt; kUnsupported for another version.
Result<wire::Reply> ParseReply(std::string_view bytes);

/// The refusal of a node as our error, and the reverse.
Error ErrorOf(const wire::Refusal& refusal);
wire::Reply RefusalOf(const Error& error);

}  // namespace plumbline
