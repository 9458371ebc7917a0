// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/message_checks.h"

#include <limits>

namespace plumbline {
namespace {

std::string OtherVersion(const char* what, unsigned version) {
  const std::string number = version == 0 ? "no version" : "version " + std::to_string(version);
  return std::string(what) + " of " + number + " of the schema was sent to a program of version " +
         std::to_string(kWireVersion) + "; run the same Plumbline on both sides";
}

template <typename Message>
bool ParseBytes(std::string_view bytes, Message& message) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return false;
  return message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

}  // namespace

ParsedRequest ParseRequest(std::string_view bytes) {
  ParsedRequest parsed;
  if (bytes.size() > kMostRequestBytes) {
    parsed.fault = MessageFault::kSize;
    parsed.sentence = "a request of " + std::to_string(bytes.size()) + " bytes was sent; " +
                      std::to_string(kMostRequestBytes) + " are taken at most";
    return parsed;
  }
  if (!ParseBytes(bytes, parsed.request)) {
    parsed.request.Clear();
    parsed.fault = MessageFault::kMalformed;
    parsed.sentence =
        "what was sent is not a Request of engine/transport/plumbline.proto; see "
        "docs/processes.md";
    return parsed;
  }
  if (parsed.request.version() != kWireVersion) {
    parsed.fault = MessageFault::kVersion;
    parsed.sentence = OtherVersion("a request", parsed.request.version());
    return parsed;
  }
  if (parsed.request.what_case() == wire::Request::WHAT_NOT_SET) {
    parsed.fault = MessageFault::kMalformed;
    parsed.sentence = "a request was sent that asks for nothing this program knows";
  }
  return parsed;
}

Result<wire::Reply> ParseReply(std::string_view bytes) {
  wire::Reply reply;
  if (!ParseBytes(bytes, reply)) {
    return Error{ErrorCode::kCorrupt,
                 "what a node sent is not a Reply of engine/transport/plumbline.proto"};
  }
  if (reply.version() != kWireVersion)
    return Error{ErrorCode::kUnsupported, OtherVersion("a reply", reply.version())};
  return reply;
}

Error ErrorOf(const wire::Refusal& refusal) {
  switch (refusal.code()) {
    case wire::Refusal::NOT_FOUND:
      return {ErrorCode::kNotFound, refusal.sentence()};
    case wire::Refusal::CORRUPT:
      return {ErrorCode::kCorrupt, refusal.sentence()};
    case wire::Refusal::DEGENERATE:
      return {ErrorCode::kDegenerate, refusal.sentence()};
    case wire::Refusal::CANCELLED:
      return {ErrorCode::kCancelled, refusal.sentence()};
    case wire::Refusal::IO:
      return {ErrorCode::kIo, refusal.sentence()};
    case wire::Refusal::UNSUPPORTED:
      return {ErrorCode::kUnsupported, refusal.sentence()};
    default:
      return {ErrorCode::kInvalidInput, refusal.sentence()};
  }
}

wire::Reply RefusalOf(const Error& error) {
  wire::Reply reply;
  wire::Refusal& refusal = *reply.mutable_refusal();
  refusal.set_sentence(error.message);
  switch (error.code) {
    case ErrorCode::kInvalidInput:
      refusal.set_code(wire::Refusal::INVALID_INPUT);
      break;
    case ErrorCode::kNotFound:
      refusal.set_code(wire::Refusal::NOT_FOUND);
      break;
    case ErrorCode::kCorrupt:
      refusal.set_code(wire::Refusal::CORRUPT);
      break;
    case ErrorCode::kDegenerate:
      refusal.set_code(wire::Refusal::DEGENERATE);
      break;
    case ErrorCode::kCancelled:
      refusal.set_code(wire::Refusal::CANCELLED);
      break;
    case ErrorCode::kIo:
      refusal.set_code(wire::Refusal::IO);
      break;
    case ErrorCode::kUnsupported:
      refusal.set_code(wire::Refusal::UNSUPPORTED);
      break;
  }
  return reply;
}

}  // namespace plumbline
