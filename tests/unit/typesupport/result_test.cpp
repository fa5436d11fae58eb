// What happens if a program does not check for an error.
#include "sft/result.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

#include "tests/unit/typesupport/result_without_exceptions.h"

namespace sft {
namespace {

/// The lines that a program prints when it reads the value of an error.
constexpr const char* stopped =
    "sft: a result is read that is an error: no number is there: bring one; write `if \\(result\\)` first";

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
    const Result<std::string> nothing = fail(Errc::no_permission, "ask the administrator");
    (void)nothing.value();
    FAIL() << "nothing was thrown";
  } catch (const tl::bad_expected_access<Error>& e) {
    EXPECT_EQ(e.error().code, Errc::no_permission);
    EXPECT_EQ(e.error().message, "ask the administrator");
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

TEST(ResultDeathTest, AnErrorThatIsTakenForAValueEndsTheProgramWithTheSentence) {
  Result<int> number = no_number();
  const Result<std::string> text = fail(Errc::unavailable, "no number is there: bring one");
  EXPECT_DEATH((void)*number, stopped);
  EXPECT_DEATH((void)*no_number(), stopped);
  EXPECT_DEATH((void)*text, stopped);
  EXPECT_DEATH((void)text->size(), stopped);
  EXPECT_DEATH((void)*number.map([](int n) { return n + 1; }), stopped);
  EXPECT_DEATH((void)*number.map_error([](Error error) { return error; }), stopped);
}

TEST(ResultDeathTest, InAProgramWithoutExceptionsSoDoesItsValue) {
  EXPECT_EQ(test::value_without_exceptions(7), 7);
  EXPECT_DEATH((void)test::value_without_exceptions(fail(Errc::unavailable, "no number is there: bring one")),
               stopped);
}

TEST(ResultDeathTest, AValueThatIsTakenForAnErrorEndsTheProgram) {
  const Result<int> seven = 7;
  EXPECT_DEATH((void)seven.error(),
               "sft: the error of a result is read that has a value; write `if \\(!result");
  EXPECT_DEATH((void)Result<void>().error(), "the error of a result is read");
}

TEST(ResultTest, GoesOnWithItsValueAndPassesItsErrorOn) {
  const auto half = [](int n) -> Result<int> {
    return n % 2 == 0 ? Result<int>(n / 2) : fail(Errc::invalid_argument, std::to_string(n) + " is odd");
  };
  const auto in_words = [](const Result<int>& result) {
    return result ? std::to_string(*result) : result.error().message;
  };
  Result<int> twelve = 12;
  EXPECT_EQ(in_words(twelve.and_then(half)), "6");
  EXPECT_EQ(in_words(twelve.and_then(half).and_then(half).and_then(half)), "3 is odd");
  EXPECT_EQ(in_words(std::as_const(twelve).map([](const int& n) { return n + 1; })), "13");
  EXPECT_EQ(in_words(no_number().transform([](int n) { return n + 1; })), "no number is there: bring one");
  EXPECT_EQ(in_words(no_number().or_else([&](const Error&) { return half(4); })), "2");
  EXPECT_EQ(in_words(twelve.or_else([&](const Error&) { return half(4); })), "12");
  EXPECT_EQ(no_number().map_error([](const Error& e) { return e.message.size(); }).error(), 29U);
  EXPECT_EQ(no_number().value_or(5), 5);
}

TEST(ResultTest, OfNothingGoesOnToo) {
  int calls = 0;
  Result<void> done;
  EXPECT_TRUE(done.map([&] { ++calls; }));
  EXPECT_EQ(*done.and_then([&]() -> Result<int> { return ++calls; }), 2);
  EXPECT_FALSE(Result<void>(fail(Errc::system, "no")).map([&] { ++calls; }));
  EXPECT_EQ(calls, 2);
}

TEST(ResultTest, ConvertsWhereItsValueDoes) {
  struct Base {
    virtual ~Base() = default;
  };
  struct Derived : Base {};
  Result<std::unique_ptr<Base>> base = Result<std::unique_ptr<Derived>>(std::make_unique<Derived>());
  EXPECT_NE(*base, nullptr);
  base = fail(Errc::system, "gone");
  EXPECT_EQ(base.error().message, "gone");
  base = std::make_unique<Derived>();
  EXPECT_TRUE(base);
  const auto has_none = []() -> Result<std::string> { return {}; };
  EXPECT_EQ(*has_none(), "");
  static_assert(!std::is_convertible_v<int, Result<std::unique_ptr<int>>>);
  static_assert(!std::is_default_constructible_v<Result<std::reference_wrapper<int>>>);
  static_assert(!std::is_copy_constructible_v<Result<std::unique_ptr<int>>>);
}

TEST(ResultTest, OfABoolIsCopiedAndNotTestedWhereItIsPassedOn) {
  Result<bool> no = false;
  const Result<bool> copied(no);
  EXPECT_FALSE(*copied);
  const Result<bool> of_number(Result<int>(0));
  EXPECT_FALSE(*of_number);
}

}  // namespace
}  // namespace sft
