// Conditions of --fail-if: their meaning, and the positions of mistakes in errors.
#include "tools/perf/criteria.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::perf {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

std::vector<std::string> failed(const char* text, const Values& values) {
  return failures(parse_criteria(text).value(), values);
}

const Values good{{"p99", 0.001}, {"p99.9", 0.003}, {"p99.99", std::nullopt},
                  {"lost", 2},    {"sent", 1000},   {"rate", 99}};

TEST(CriteriaTest, AConditionThatHoldsIsTold) {
  EXPECT_THAT(failed("p99 > 2 ms, lost > 2", good), IsEmpty());
  EXPECT_THAT(failed("p99 > 2 ms, lost > 1", good), ElementsAre("lost > 1: lost is 2"));
  EXPECT_THAT(failed("p99.9>=3ms", good), ElementsAre("p99.9>=3ms: p99.9 is 0.003"));
  EXPECT_THAT(failed("p99 > 900 us", good), ElementsAre(StartsWith("p99 > 900 us: p99 is 0.001")));
}

TEST(CriteriaTest, APartOfTheSamplesIsThatOfAllSent) {
  EXPECT_THAT(failed("lost > 0.2 %", good), IsEmpty());
  EXPECT_THAT(failed("lost > 0.19 %", good), ElementsAre("lost > 0.19 %: lost is 2"));
}

TEST(CriteriaTest, ARateMayBeInKilohertz) {
  EXPECT_THAT(failed("rate < 0.1 kHz", good), ElementsAre("rate < 0.1 kHz: rate is 99"));
  EXPECT_THAT(failed("rate < 99", good), IsEmpty());
}

TEST(CriteriaTest, AValueThatNobodyKnowsFailsARun) {
  EXPECT_THAT(failed("p99.99 > 1 s", good), ElementsAre("p99.99 > 1 s: p99.99 is not known"));
}

TEST(CriteriaTest, AWrongTextIsNamedByItsPosition) {
  struct Wrong {
    const char* text;
    const char* where;
  };
  for (const auto& [text, where] :
       {Wrong{"", "at character 1 there is the end, but expected is one of min,"},
        Wrong{"p98 > 1 ms", "at character 1 "},
        Wrong{"p99 2 ms", "at character 5 there is '2 ms', but expected is one of >"},
        Wrong{"p99 > ms", "at character 7 "},
        Wrong{"lost > nan", "at character 8 there is 'nan', but expected is a number"},
        Wrong{"p99 > inf s", "at character 7 "},
        Wrong{"p99 > 2", "at character 8 there is the end, but expected is a unit"},
        Wrong{"p99 > 2 %", "at character 9 "}, Wrong{"lost > 1 ms", "at character 10 "},
        Wrong{"p99 > 2 ms lost > 1", "at character 12 "},
        Wrong{"p99 > 2 ms,", "at character 12 there is the end"}}) {
    const auto parsed = parse_criteria(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_THAT(parsed.error().message, HasSubstr(where));
  }
}

}  // namespace
}  // namespace sft::perf
