// SPDX-License-Identifier: Apache-2.0
#include "engine/base/options.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plumbline {

enum class Flavour { kSweet, kSour };
template <>
struct EnumNames<Flavour> {
  static constexpr std::string_view names[] = {"sweet", "sour"};
};

struct SoupOptions {
  int num_carrots = 3;
  double salt_g = 1.5;
  bool hot = true;
  Flavour flavour = Flavour::kSweet;
  std::string name = "soup";
  bool operator==(const SoupOptions&) const = default;
};

template <typename Visitor>
void VisitFields(SoupOptions& o, Visitor&& visit) {
  visit(o.num_carrots,
        FieldInfo{.name = "num_carrots", .unit = "", .help = "how many", .min = 0, .max = 10});
  visit(o.salt_g,
        FieldInfo{.name = "salt_g", .unit = "g", .help = "how salty", .min = 0, .max = 5});
  visit(o.hot, FieldInfo{.name = "hot", .unit = "", .help = "served hot"});
  visit(o.flavour, FieldInfo{.name = "flavour", .unit = "", .help = "how it tastes"});
  visit(o.name, FieldInfo{.name = "name", .unit = "", .help = "on the menu"});
}

namespace {

using testing::AllOf;
using testing::HasSubstr;

/// The sentence with which `assignment` is refused; "accepted" if it is not. A refusal must change
/// nothing.
std::string Refusal(const std::string& assignment) {
  SoupOptions options;
  const Status status = SetOption(assignment, options);
  if (status.ok()) return "accepted";
  EXPECT_EQ(status.error().code, ErrorCode::kInvalidInput);
  EXPECT_EQ(options, SoupOptions());
  return status.error().message;
}

TEST(Options, SurviveARoundTripThroughJson) {
  const SoupOptions changed{
      .num_carrots = 7, .salt_g = 0.25, .hot = false, .flavour = Flavour::kSour, .name = "x"};
  SoupOptions read;
  ASSERT_TRUE(OptionsFromJson(OptionsToJson(changed), read).ok());
  EXPECT_EQ(read, changed);
}

TEST(Options, KeepTheDefaultOfAMissingKey) {
  SoupOptions options;
  ASSERT_TRUE(OptionsFromJson({{"salt_g", 2}}, options).ok());
  EXPECT_EQ(options, (SoupOptions{.salt_g = 2}));
}

TEST(Options, NameTheNearestKeyForAnUnknownOne) {
  EXPECT_THAT(Refusal("num_carots=2"),
              AllOf(HasSubstr("'num_carots'"), HasSubstr("'num_carrots'")));
  EXPECT_THAT(Refusal("flavor=sour"), HasSubstr("'flavour'"));
}

TEST(Options, RefuseAValueOutOfRangeAndSayTheRangeWithItsUnit) {
  EXPECT_THAT(Refusal("salt_g=6"), AllOf(HasSubstr("between 0 and 5 g"), HasSubstr("6")));
  EXPECT_THAT(Refusal("num_carrots=-1"), HasSubstr("between 0 and 10"));
  EXPECT_EQ(Refusal("salt_g=5"), "accepted");
}

TEST(Options, RefuseTheWrongType) {
  EXPECT_THAT(Refusal("num_carrots=2.5"), HasSubstr("whole number"));
  EXPECT_THAT(Refusal("salt_g=much"), HasSubstr("a number"));
  EXPECT_THAT(Refusal("hot=1"), HasSubstr("true or false"));
  EXPECT_THAT(Refusal("name=3"), HasSubstr("a text"));
}

TEST(Options, ListTheNamesOfAnEnumeration) {
  EXPECT_THAT(Refusal("flavour=bitter"), HasSubstr("one of sweet, sour"));
  EXPECT_THAT(Refusal("flavour=1"), HasSubstr("a name"));
  SoupOptions options;
  ASSERT_TRUE(SetOption("flavour=sour", options).ok());
  EXPECT_EQ(options.flavour, Flavour::kSour);
}

TEST(Options, AreSetByTextAsOnTheCommandLine) {
  SoupOptions options;
  for (const char* assignment : {"num_carrots=4", "salt_g=1e-1", "hot=false", "name=broth=x"}) {
    const Status status = SetOption(assignment, options);
    ASSERT_TRUE(status.ok()) << status.error().message;
  }
  EXPECT_EQ(options,
            (SoupOptions{.num_carrots = 4, .salt_g = 0.1, .hot = false, .name = "broth=x"}));
  EXPECT_THAT(Refusal("num_carrots"), HasSubstr("key=value"));
}

TEST(Options, MustBeAJsonObject) {
  SoupOptions options;
  EXPECT_FALSE(OptionsFromJson(nlohmann::json::array({1}), options).ok());
}

TEST(NearestName, CountsInsertionsDeletionsAndSubstitutions) {
  EXPECT_EQ(NearestName("jmp_scop", {"box", "jump_scope", "jump_rate"}), "jump_scope");
  EXPECT_EQ(NearestName("anything", {}), "");
}

}  // namespace
}  // namespace plumbline
