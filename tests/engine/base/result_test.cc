// SPDX-License-Identifier: Apache-2.0
#include "engine/base/result.h"

#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(Result, HoldsAValueOrAnError) {
  const Result<int> good = 3;
  const Result<int> bad = Error{ErrorCode::kNotFound, "there is no spoon"};
  EXPECT_TRUE(good.ok());
  EXPECT_EQ(*good, 3);
  EXPECT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().code, ErrorCode::kNotFound);
}

TEST(Result, ThrowsTheErrorsSentenceIfAskedForAValueItDoesNotHave) {
  const Result<int> bad = Error{ErrorCode::kNotFound, "there is no spoon"};
  try {
    static_cast<void>(bad.value());
    FAIL() << "no ContractError";
  } catch (const ContractError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("there is no spoon"));
  }
  EXPECT_THROW(static_cast<void>(Result<int>(3).error()), ContractError);
  EXPECT_THROW(static_cast<void>(Status().error()), ContractError);
}

TEST(Result, MovesWhatCannotBeCopied) {
  Result<std::unique_ptr<int>> result = std::make_unique<int>(4);
  const std::unique_ptr<int> taken = std::move(result).value();
  EXPECT_EQ(*taken, 4);
}

TEST(Check, SaysWhereAndWhy) {
  const auto fail = [] { PLB_CHECK(1 + 1 == 3) << "sums " << 2; };
  try {
    fail();
    FAIL() << "no ContractError";
  } catch (const ContractError& error) {
    EXPECT_THAT(error.what(),
                testing::ContainsRegex("result_test.cc:[0-9]+: check failed: 1 \\+ 1 == 3 sums 2"));
  }
}

}  // namespace
}  // namespace plumbline
