// The consequences of an error that a program does not check.
#include "sft/result.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>

namespace sft {
namespace {

Result<int> no_number() { return fail(Errc::unavailable, "no number is there: bring one"); }

TEST(ResultTest, TheValueOfAnErrorIsAnExceptionThatSaysWhatTheErrorSays) {
  try {
    (void)no_number().value();
    FAIL() << "nothing was thrown";
  } catch (const std::exception& e) {
    EXPECT_STREQ(e.what(), "no number is there: bring one");
  }
}

TEST(ResultTest, TheExceptionHasTheError) {
  try {
    const Result<std::string> nothing = fail(Errc::no_permission, "ask somebody");
    (void)nothing.value();
    FAIL() << "nothing was thrown";
  } catch (const tl::bad_expected_access<Error>& e) {
    EXPECT_EQ(e.error().code, Errc::no_permission);
    EXPECT_EQ(e.error().message, "ask somebody");
  }
}

TEST(ResultTest, AValueThatCanOnlyBeMovedIsThereWhereThereIsNoError) {
  Result<std::unique_ptr<int>> made = std::make_unique<int>(7);
  EXPECT_EQ(*made.value(), 7);
  EXPECT_EQ(*std::move(made).value(), 7);
}

TEST(ResultDeathTest, AProgramThatDoesNotCatchItEndsWithTheSentence) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(std::thread([] { (void)no_number().value(); }).join(),
               "what\\(\\):  no number is there: bring one");
}

}  // namespace
}  // namespace sft
