// Loans. Memory is reserved, filled and returned, and no bytes other than those of the message are sent.
#include <gtest/gtest.h>

#include <algorithm>
#include <views.hpp>

#include "tests/support/encoded.h"
#include "tests/support/random_value.h"
#include "tests/unit/core/publish/publisher_fixture.h"

namespace switches {
enum class Flags : std::uint16_t { left = 1, right = 2, both_ways = 4 };

/// A type in the form that the generator writes, reduced to the parts that loans use.
struct Switches {
  std::uint8_t lead = 0;
  Flags flags{};

  template <class Root = Switches, std::size_t First = 0>
  struct Fields : sft::detail::FieldNode<Root, First, 2> {
    static constexpr sft::detail::FieldNode<Root, First, 1> lead{};
    static constexpr sft::detail::FieldNode<Root, First + 1, 1> flags{};
  };
  using Field = Fields<>;
  struct LoanSizes {};
  template <class Loaned>
  struct LoanView {
    static constexpr auto reservations(const LoanSizes&) { return sft::detail::joined(); }
    explicit LoanView(Loaned) {}
  };
};
}  // namespace switches

template <>
struct sft::detail::EnumTable<switches::Flags> {
  static constexpr std::array enumerators{sft::detail::Enumerator{"left", 1},
                                          sft::detail::Enumerator{"right", 2}};
  static constexpr sft::EnumType type{"switches::Flags", true, enumerators};
};

template <>
struct sft::detail::TypeTable<switches::Switches> {
  using T = switches::Switches;
  static constexpr std::array members{
      sft::detail::member<std::uint8_t>("lead", sft::detail::Kind::uint8, offsetof(T, lead)),
      sft::detail::member<switches::Flags>("flags", sft::detail::Kind::uint16, offsetof(T, flags))};
  static constexpr sft::StructType type{"switches::Switches", members};
};

namespace sft::core::test {
namespace {

using namespace detail;

using sft::test::Encoded;
using views::Color;
using views::Recording;
using F = Recording::Field;
using Sizes = Recording::LoanSizes;

class LoanTest : public sft::test::RandomTest {
 protected:
  Loan<Recording> loan(const Sizes& sizes) { return publisher->loan({}, sizes).value(); }

  /// Expects header, index, padding and body to equal those of a new encoding of `message`.
  void expect_sent(const Recording& message) {
    ASSERT_TRUE(publisher.has_sent());
    const Encoded expected(message);
    const SampleBuffer& sent = publisher.sent();
    EXPECT_EQ(publisher.sent_body(), expected.bytes());
    EXPECT_TRUE(std::equal(sent.index(), sent.index() + expected.slots(), expected.state().index));
    const auto* padding = reinterpret_cast<const std::byte*>(sent.index() + expected.slots());
    const std::byte* encapsulation = sent.data + sent.header().body_offset - encapsulation_bytes;
    EXPECT_TRUE(std::all_of(padding, encapsulation, [](std::byte b) { return b == std::byte{0}; }));
    EXPECT_EQ(std::memcmp(encapsulation, encapsulation_cdr_le.data(), encapsulation_bytes), 0);
    EXPECT_EQ(sent.header().diverted_sequence, sent.header().sequence - 1) << "all go by UDP alone";
  }

  PublisherOf<Recording> publisher;
};

TEST_F(LoanTest, SeveralSequencesAreReservedAlsoInNestedStructs) {
  auto loan = this->loan({.stamps = 2, .left = {.colors = 3}, .cloud = {.data = 5}});
  EXPECT_EQ(loan->stamps().size(), 2U);
  EXPECT_EQ(loan->left().colors().size(), 3U);
  EXPECT_EQ(loan->cloud().data().size(), 5U);
  EXPECT_TRUE(loan->right().colors().empty());
  Recording expected;
  expected.stamps = {-1, 7};
  expected.left.colors = {Color::RED, Color::BLACK, Color::GREEN};
  expected.cloud.data = {1, 2, 3, 4, 5};
  std::ranges::copy(expected.stamps, loan->stamps().begin());
  std::ranges::copy(expected.left.colors, loan->left().colors().begin());
  std::ranges::copy(expected.cloud.data, loan->cloud().data().begin());
  EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);
  expect_sent(expected);
}

TEST_F(LoanTest, AShrunkSequenceIsPublishedAsIfOnlyThatWereReserved) {
  auto loan = this->loan({.stamps = 100, .left = {.ranges = 10}, .weights = 3});
  const auto stamps = loan->stamps();
  for (std::size_t i = 0; i < 100; ++i) stamps[i] = static_cast<std::int64_t>(i);
  EXPECT_EQ(loan.shrink(F::stamps, 3), ShrinkStatus::ok);
  EXPECT_EQ(loan->stamps().size(), 3U);
  stamps[99] = 5;  // this memory still belongs to the loan
  EXPECT_EQ(loan.shrink(F::left.ranges, 1), ShrinkStatus::ok);
  loan->left().ranges()[0] = 0.5;
  loan->weights()[2] = 2;
  loan.set(F::tail, 9);
  EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);

  Recording expected;
  expected.stamps = {0, 1, 2};
  expected.left.ranges = {0.5};
  expected.weights = {0, 0, 2};
  expected.tail = 9;
  expect_sent(expected);
}

TEST_F(LoanTest, ShrinkingAgainMayGiveBackLess) {
  auto loan = this->loan({.weights = 4});
  loan->weights()[3] = 8;
  EXPECT_EQ(loan.shrink(F::weights, 0), ShrinkStatus::ok);
  EXPECT_TRUE(loan->weights().empty());
  EXPECT_EQ(loan.shrink(F::weights, 4), ShrinkStatus::ok);
  std::move(loan).publish();
  Recording expected;
  expected.weights = {0, 0, 0, 8};
  expect_sent(expected);
}

TEST_F(LoanTest, WhatCannotBeShrunkIsAnErrorThatSaysWhyAndChangesNothing) {
  auto loan = this->loan({.stamps = 2});
  EXPECT_EQ(loan.shrink(F::stamps, 3), ShrinkStatus::too_long);
  EXPECT_EQ(loan.shrink(F::weights, 0), ShrinkStatus::not_reserved);
  EXPECT_STREQ(to_string(ShrinkStatus::too_long), "longer than what the loan reserved for this sequence");
  std::move(loan).publish();
  Recording expected;
  expected.stamps = {0, 0};
  expect_sent(expected);
}

TEST_F(LoanTest, BoundsHold) {
  EXPECT_TRUE(publisher->loan({}, {.left = {.pixels = 1000}}));
  const auto refused = publisher->loan({}, {.left = {.pixels = 1001}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::invalid_argument);
}

TEST_F(LoanTest, ScalarsEnumerationsAndBooleansAreSet) {
  auto loan = this->loan({});
  loan.set(F::color, Color::GREEN);
  loan.set(F::good, true);
  loan.set(F::left.last, true);
  loan.set(F::cloud.header.stamp.sec, -4);
  std::move(loan).publish();
  Recording expected;
  expected.color = Color::GREEN;
  expected.good = true;
  expected.left.last = true;
  expected.cloud.header.stamp.sec = -4;
  expect_sent(expected);
}

TEST(LoanOfABitmaskTest, TakesFlagsAndAnyCombinationOfThem) {
  using switches::Flags;
  using switches::Switches;
  PublisherOf<Switches> publisher;
  auto loan = publisher->loan({}).value();
  loan.set(Switches::Field::flags, Flags::right);
  std::move(loan).publish();
  EXPECT_EQ(publisher.sent_body(), Encoded(Switches{.flags = Flags::right}).bytes());
  auto second = publisher->loan({}).value();
  second.set(Switches::Field::flags, 3);
  std::move(second).publish();
  EXPECT_EQ(publisher.sent_body(), Encoded(Switches{.flags = Flags{3}}).bytes());
}

TEST_F(LoanTest, OnceItIsGoneItIsAnErrorAndNotACrash) {
  auto loan = this->loan({.stamps = 2});
  auto moved = std::move(loan);
  EXPECT_EQ(loan.shrink(F::stamps, 1), ShrinkStatus::no_loan);  // NOLINT(bugprone-use-after-move)
  EXPECT_TRUE(loan->stamps().empty());
  EXPECT_TRUE(loan->cloud().data().empty());
  loan.set(F::tail, 1);
  EXPECT_EQ(std::move(loan).publish(), PublishStatus::no_loan);
  EXPECT_EQ(std::move(moved).publish(), PublishStatus::ok);
  EXPECT_EQ(std::move(moved).publish(), PublishStatus::no_loan);  // NOLINT(bugprone-use-after-move)
  EXPECT_EQ(publisher->status().published, 1U);
}

TEST_F(LoanTest, ReservedElementsAreZeroWhateverTheMemoryHeldBefore) {
  for (int round = 0; round < 5; ++round) {
    publisher.poison_memory();
    auto loan = this->loan({.stamps = 100, .right = {.pixels = 999}, .cloud = {.data = 70'001}});
    loan->stamps()[50] = 1;
    loan.shrink(F::stamps, 60);
    loan.shrink(F::cloud.data, 60'001);
    std::move(loan).publish();
    Recording expected;
    expected.stamps.resize(60);
    expected.stamps[50] = 1;
    expected.right.pixels.resize(999);
    expected.cloud.data.resize(60'001);
    expect_sent(expected);
  }
}

TEST_F(LoanTest, ForOverwriteLeavesElementsAsTheyAreAndNothingElse) {
  publisher.poison_memory();
  auto loan = publisher->loan_for_overwrite({}, {.stamps = 10, .cloud = {.data = 9}}).value();
  EXPECT_EQ(loan->cloud().data()[4], 0xA5);
  std::ranges::fill(loan->cloud().data(), std::uint8_t{1});
  loan->stamps()[0] = 6;
  loan.shrink(F::stamps, 1);
  std::move(loan).publish();
  Recording expected;
  expected.stamps = {6};
  expected.cloud.data.assign(9, 1);
  expect_sent(expected);
}

TEST_F(LoanTest, OfAnyMessageHoweverReservedAndShrunkIsItsEncoding) {
  sft::test::RandomValues values(random);
  // Reserves memory for some sequences, sometimes more than they need. In the prototype these sequences
  // have other elements.
  const auto reserve = [&](auto& size, auto& in_prototype, const auto& value, std::size_t most = 100'000) {
    if (random() % 3 == 0) return;
    const std::size_t more = random() % 2 == 0 ? 0 : random() % 5000;
    size = static_cast<std::uint32_t>(std::min(value.size() + more, most));
    in_prototype.resize(random() % 3);
  };
  for (int round = 0; round < 500 && !HasFailure(); ++round) {
    publisher.poison_memory();
    Recording value;
    values.fill(TypeTable<Recording>::type, &value);
    Recording prototype = value;
    Sizes sizes;
    reserve(sizes.stamps, prototype.stamps, value.stamps);
    reserve(sizes.left.ranges, prototype.left.ranges, value.left.ranges);
    reserve(sizes.left.pixels, prototype.left.pixels, value.left.pixels, 1000);
    reserve(sizes.right.colors, prototype.right.colors, value.right.colors);
    reserve(sizes.cloud.data, prototype.cloud.data, value.cloud.data);
    reserve(sizes.weights, prototype.weights, value.weights);
    auto loan = publisher->loan_for_overwrite(prototype, sizes).value();
    const auto fill = [&](const auto& size, const auto& field, auto span, const auto& from) {
      if (!size) return;
      std::ranges::copy(from, span.begin());
      EXPECT_EQ(loan.shrink(field, static_cast<std::uint32_t>(from.size())), ShrinkStatus::ok);
    };
    fill(sizes.stamps, F::stamps, loan->stamps(), value.stamps);
    fill(sizes.left.ranges, F::left.ranges, loan->left().ranges(), value.left.ranges);
    fill(sizes.left.pixels, F::left.pixels, loan->left().pixels(), value.left.pixels);
    fill(sizes.right.colors, F::right.colors, loan->right().colors(), value.right.colors);
    fill(sizes.cloud.data, F::cloud.data, loan->cloud().data(), value.cloud.data);
    fill(sizes.weights, F::weights, loan->weights(), value.weights);
    ASSERT_EQ(std::move(loan).publish(), PublishStatus::ok);
    expect_sent(value);
  }
}

TEST_F(LoanTest, BytesThatABrokenProgramChangedMeanwhileAreNotPublished) {
  for (int round = 0; round < 2000; ++round) {
    auto core_loan = publisher->loan({}, {.stamps = 20, .cloud = {.data = 300}}).value();
    // The body begins 8 bytes before the first stamp, and the index precedes the body.
    auto* const body = reinterpret_cast<std::byte*>(core_loan->stamps().data()) - 8;
    core_loan.shrink(F::stamps, 3);
    for (int i = 0; i < 4; ++i) {
      const std::size_t back = 8 + 4 * (random() % type_support<Recording>().index_slots());
      const auto value = static_cast<std::uint32_t>(random() % 2 == 0 ? random() : random() % 600);
      std::memcpy(body - back, &value, sizeof value);
      body[random() % 400] = static_cast<std::byte>(random());
    }
    const PublishStatus status = std::move(core_loan).publish();
    EXPECT_TRUE(status == PublishStatus::ok || status == PublishStatus::invalid);
  }
}

}  // namespace
}  // namespace sft::core::test
