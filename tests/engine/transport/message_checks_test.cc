// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/message_checks.h"

#include <string>

#include <gmock/gmock.h>

namespace plumbline {
namespace {

wire::Request ImageRequest(int frame) {
  wire::Request request;
  request.set_version(kWireVersion);
  request.set_id(7);
  request.mutable_image()->set_frame(frame);
  return request;
}

TEST(MessageChecks, TakeARequestOfOurVersion) {
  const ParsedRequest parsed = ParseRequest(ImageRequest(12).SerializeAsString());
  EXPECT_EQ(parsed.fault, MessageFault::kNone);
  EXPECT_EQ(parsed.request.image().frame(), 12);
}

TEST(MessageChecks, RefuseOldFutureHugeAndMalformedOnesInASentence) {
  wire::Request old = ImageRequest(1), future = ImageRequest(1), nothing = ImageRequest(1);
  old.clear_version();
  future.set_version(kWireVersion + 1);
  nothing.clear_what();
  EXPECT_EQ(ParseRequest(old.SerializeAsString()).fault, MessageFault::kVersion);
  const ParsedRequest newer = ParseRequest(future.SerializeAsString());
  EXPECT_EQ(newer.fault, MessageFault::kVersion);
  EXPECT_EQ(newer.request.id(), 7u) << "who asked must be able to tell";
  EXPECT_THAT(newer.sentence, testing::HasSubstr("version 2"));
  EXPECT_EQ(ParseRequest(nothing.SerializeAsString()).fault, MessageFault::kMalformed);
  EXPECT_EQ(ParseRequest("no message").fault, MessageFault::kMalformed);
  EXPECT_EQ(ParseRequest("").fault, MessageFault::kVersion);
  EXPECT_EQ(ParseRequest(std::string(kMostRequestBytes + 1, 'x')).fault, MessageFault::kSize);
}

TEST(MessageChecks, TakeFieldsThatAreNotKnown) {
  // Field 2000, a number, of a newer program that kept the version.
  const std::string bytes = ImageRequest(3).SerializeAsString() + "\x80\x7d\x05";
  EXPECT_EQ(ParseRequest(bytes).fault, MessageFault::kNone);
}

TEST(MessageChecks, RefusalsKeepCodeAndSentence) {
  for (const ErrorCode code :
       {ErrorCode::kInvalidInput, ErrorCode::kNotFound, ErrorCode::kCorrupt, ErrorCode::kDegenerate,
        ErrorCode::kCancelled, ErrorCode::kIo, ErrorCode::kUnsupported}) {
    const Error error = ErrorOf(RefusalOf({code, "no \xff"}).refusal());
    EXPECT_EQ(error.code, code);
    EXPECT_EQ(error.message, "no \xff") << "also where a file's name is not UTF-8";
  }
}

}  // namespace
}  // namespace plumbline
