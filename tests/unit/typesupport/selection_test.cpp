// Selections as values: the laws of union, of inclusion and of parts of parts, and the encoding. The tests
// use random selections of a type with all kinds of fields.
#include "sft/selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "tests/support/test_seed.h"

namespace sft {
namespace {

using Condition = Selection::Condition;
using Part = Selection::Part;
using Range = Selection::Range;

constexpr std::size_t leaves = 70;

class SelectionTest : public testing::Test {
 protected:
  std::uint32_t below(std::uint32_t end) { return static_cast<std::uint32_t>(random_() % end); }
  bool coin(std::uint32_t sides = 2) { return below(sides) == 0; }

  Range range() {
    if (coin(3)) return {};
    Range range{.begin = below(5), .end = coin() ? Range::no_end : below(12), .step = 1 + below(4)};
    range.end = std::max(range.end, range.begin);
    return range;
  }
  Part part(std::uint32_t leaf) {
    Part part{.leaf = leaf, .rows = range(), .columns = range()};
    for (const char* name : {"intensity", "x", "y", "z"})
      if (coin()) part.channels.emplace_back(name);
    return part;
  }
  void add_conditions(std::vector<Condition>& to, std::size_t depth) {
    Condition& condition = to.emplace_back();
    condition.kind = static_cast<Condition::Kind>(below(depth < 4 ? 6 : 4) + (depth < 4 ? 0 : 2));
    const std::uint32_t children = 1 + below(3);
    switch (condition.kind) {
      case Condition::Kind::all_of:
      case Condition::Kind::any_of:
        condition.children = children;
        for (std::uint32_t i = 0; i < children; ++i) add_conditions(to, depth + 1);
        return;
      case Condition::Kind::compare:
        condition.comparison = static_cast<Condition::Comparison>(below(6));
        condition.leaves = {below(leaves)};
        if (coin()) condition.number = -1.5 * below(9);
        if (coin()) condition.number = std::int64_t{below(9)} - 4;
        return;
      case Condition::Kind::changed:
        condition.leaves = {below(leaves), below(leaves)};
        condition.is_percent = coin();
        if (coin()) condition.number = 0.25 * below(9);
        return;
      case Condition::Kind::nth:
      case Condition::Kind::elapsed:
        condition.number = std::uint64_t{1} + below(1000);
        return;
    }
  }
  Selection selection(bool may_have_gate = true) {
    FieldMask mask(leaves);
    for (std::uint32_t i = below(6); i > 0; --i) mask.insert(below(leaves));
    std::vector<Part> parts;
    for (std::uint32_t leaf = below(20); leaf < leaves && parts.size() < 4; leaf += 1 + below(3))
      parts.push_back(part(leaf));
    Selection::Gate gate;
    if (may_have_gate && coin()) {
      add_conditions(gate.conditions, 1);
      if (gate.conditions.size() > 20) gate.conditions.clear();
    }
    if (may_have_gate && coin()) gate.least_period = std::chrono::microseconds(1 + below(1'000'000));
    return Selection::make(std::move(mask), std::move(parts), std::move(gate)).value();
  }

 private:
  std::mt19937_64 random_{test::test_seed()};
};

/// A program other than SFT may send such a selection.
TEST(Selections, WithADeadbandThatIsNoNumberAreNotReadFromTheirBytes) {
  const double usual = 0.1234567, none = std::nan("");
  const Selection one =
      Selection::make(FieldMask(10), {},
                      {.conditions = {{.kind = Condition::Kind::changed, .leaves = {1}, .number = usual}}})
          .value();
  std::vector<std::byte> bytes = one.to_bytes();
  const auto* const wanted = reinterpret_cast<const std::byte*>(&usual);
  const auto at = std::search(bytes.begin(), bytes.end(), wanted, wanted + sizeof usual);
  ASSERT_NE(at, bytes.end());
  std::memcpy(&*at, &none, sizeof none);
  EXPECT_FALSE(Selection::from_bytes(bytes, 10));
}

TEST_F(SelectionTest, AreReadFromTheirBytesAndFromNoOthers) {
  SCOPED_TRACE(test::how_to_repeat());
  for (int i = 0; i < 2000; ++i) {
    const Selection one = selection();
    const std::vector<std::byte> bytes = one.to_bytes();
    const Result<Selection> again = Selection::from_bytes(bytes, leaves);
    ASSERT_TRUE(again);
    EXPECT_EQ(*again, one);
    EXPECT_EQ(again->what_hash(), one.what_hash());
    EXPECT_EQ(again->gate_hash(), one.gate_hash());
    std::vector<std::byte> other = bytes;
    other[below(static_cast<std::uint32_t>(other.size()))] ^= static_cast<std::byte>(1U << below(8));
    if (const Result<Selection> changed = Selection::from_bytes(other, leaves)) {
      EXPECT_EQ(changed->to_bytes(), other);
    }
    other = bytes;
    other.resize(below(static_cast<std::uint32_t>(other.size())));
    EXPECT_FALSE(Selection::from_bytes(other, leaves)) << "it is cut off";
    other = bytes;
    other.push_back(std::byte{});
    EXPECT_FALSE(Selection::from_bytes(other, leaves)) << "something is behind it";
  }
}

TEST_F(SelectionTest, OfWholeFieldsAreLikeMasks) {
  FieldMask mask(leaves);
  mask.insert(3);
  mask.insert(69);
  const Selection whole(mask);
  EXPECT_TRUE(whole.is_mask());
  EXPECT_EQ(whole.what_hash(), mask.hash());
  EXPECT_EQ(whole.gate_hash(), 0U);
  EXPECT_EQ(Selection::make(mask, {{.leaf = 3}}, {}).value(), whole) << "a part that is all";
  EXPECT_EQ(whole.to_bytes().size(), 2 + 9U);
}

TEST_F(SelectionTest, JoinInAnyOrderToTheSame) {
  SCOPED_TRACE(test::how_to_repeat());
  for (int i = 0; i < 2000; ++i) {
    const Selection a = selection(), b = selection(), c = selection();
    EXPECT_EQ(a.joined(a), a);
    EXPECT_EQ(a.joined(b), b.joined(a));
    EXPECT_EQ(a.without_gate().joined(b).joined(c).without_gate(),
              a.joined(b.without_gate().joined(c)).without_gate());
  }
}

TEST_F(SelectionTest, JoinToWholeFieldsWhereALimitIsExceeded) {
  const auto of = [](std::vector<Part> parts) {
    return Selection::make(FieldMask(leaves), std::move(parts), {.least_period = std::chrono::hours(1)})
        .value();
  };
  const auto expect_whole = [](const Selection& a, const Selection& b) {
    const Selection both = a.joined(b);
    EXPECT_TRUE(both.parts().empty());
    EXPECT_EQ(both.mask(), a.mask() | b.mask());
    EXPECT_EQ(both.gate(), a.gate());
    EXPECT_EQ(both, b.joined(a));
    EXPECT_EQ(Selection::from_bytes(both.to_bytes(), leaves).value(), both);
  };
  const auto parts = [&](std::uint32_t from, std::uint32_t to) {
    std::vector<Part> all;
    for (; from < to; ++from) all.push_back({.leaf = from, .columns = {.begin = 1}});
    return of(std::move(all));
  };
  EXPECT_EQ(parts(0, 8).joined(parts(8, 16)).parts().size(), 16U);
  expect_whole(parts(0, 8), parts(8, 17));
  const auto channels = [&](char first, std::size_t count, std::size_t bytes) {
    Part part{.leaf = 3};
    for (std::size_t i = 0; i < count; ++i)
      part.channels.push_back(first + std::to_string(i) + std::string(bytes, '_'));
    return of({part});
  };
  EXPECT_EQ(channels('a', 32, 0).joined(channels('b', 32, 0)).parts()[0].channels.size(), 64U);
  expect_whole(channels('a', 32, 0), channels('b', 33, 0));
  expect_whole(channels('a', 5, 240), channels('b', 5, 240));
}

TEST_F(SelectionTest, HaveAllOfWhatTheyWereJoinedTo) {
  SCOPED_TRACE(test::how_to_repeat());
  for (int i = 0; i < 2000; ++i) {
    const Selection a = selection().without_gate(), b = selection().without_gate();
    const Selection both = a.joined(b);
    EXPECT_EQ(both.joined(a), both);
    EXPECT_EQ(both.joined(b), both);
    EXPECT_EQ(both == a && both == b, a == b);
  }
}

/// Returns the indices less than `count` that a range keeps.
std::vector<std::uint32_t> kept(const Range& range, std::uint32_t count) {
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = range.begin; i < std::min(range.end, count); i += range.step) indices.push_back(i);
  return indices;
}

TEST_F(SelectionTest, HaveRangesOfRanges) {
  SCOPED_TRACE(test::how_to_repeat());
  constexpr std::uint32_t count = 40;
  for (int i = 0; i < 20'000; ++i) {
    const Range outer = range(), inner = range();
    const std::vector<std::uint32_t> of_outer = kept(outer, count);
    EXPECT_EQ(outer.size_of(count), of_outer.size());
    EXPECT_EQ(kept(outer.canonical(), count), of_outer);
    std::vector<std::uint32_t> of_both;
    for (const std::uint32_t at : kept(inner, static_cast<std::uint32_t>(of_outer.size())))
      of_both.push_back(of_outer[at]);
    EXPECT_EQ(kept(outer.then(inner), count), of_both);
  }
}

TEST_F(SelectionTest, HaveRangesThatDoNotOverflow) {
  const Range far{.begin = 4'000'000'000, .step = 4'000'000'000};
  EXPECT_EQ(far.then({.begin = 1}), (Range{.begin = 0, .end = 0}));
  EXPECT_EQ((Range{.step = 1U << 31}.then({.step = 1U << 31})), (Range{.begin = 0, .end = 1}));
  EXPECT_EQ(far.size_of(UINT32_MAX), 1U);
  EXPECT_EQ(far.canonical(), (Range{.begin = 4'000'000'000, .end = 4'000'000'001})) << "nothing is behind it";
  const Range last{.begin = UINT32_MAX - 1, .step = 7};
  EXPECT_EQ(last.canonical(), (Range{.begin = UINT32_MAX - 1})) << "an index more would be no_end";
  EXPECT_TRUE(Range{.step = 2}.then({.begin = 1, .end = 0}).is_empty());
}

TEST_F(SelectionTest, HaveOneNumberInOneWay) {
  const auto gate_of = [](Condition condition) {
    return Selection(FieldMask(leaves)).with_gate({.conditions = {std::move(condition)}}).value();
  };
  const auto limit = [&](Selection::Number number) {
    return gate_of({.kind = Condition::Kind::compare, .leaves = {1}, .number = number});
  };
  EXPECT_EQ(limit(60.0), limit(std::uint64_t{60}));
  EXPECT_EQ(limit(60.0).gate_hash(), limit(std::int64_t{60}).gate_hash());
  EXPECT_EQ(limit(-0.0).to_bytes(), limit(std::uint64_t{0}).to_bytes());
  EXPECT_EQ(limit(-0x1p63), limit(INT64_MIN));
  EXPECT_NE(limit(0x1p64), limit(UINT64_MAX));
  const auto third = [&](Selection::Number n) {
    return gate_of({.kind = Condition::Kind::nth, .number = n});
  };
  EXPECT_EQ(third(std::int64_t{3}), third(std::uint64_t{3}));
  Condition changed{.kind = Condition::Kind::changed, .leaves = {1}};
  const Selection any_change = gate_of(changed);
  changed.is_percent = true;
  EXPECT_EQ(gate_of(changed), any_change) << "0 percent";
}

TEST_F(SelectionTest, AreRefusedWhereTheyMakeNoSense) {
  const auto refusal = [](std::vector<Part> parts, std::vector<Condition> conditions = {}) {
    const auto made =
        Selection::make(FieldMask(leaves), std::move(parts), {.conditions = std::move(conditions)});
    return made ? std::string() : made.error().message;
  };
  EXPECT_EQ(refusal({{.leaf = leaves}}), "a part is of a field that the type lacks");
  EXPECT_EQ(refusal({{.leaf = 1}, {.leaf = 1}}), "two parts of one field");
  EXPECT_EQ(refusal({{.leaf = 1, .columns = {.step = 0}}}), "a step of 0 keeps nothing; steps count from 1");
  EXPECT_EQ(refusal({}, {{.kind = Condition::Kind::all_of}}),
            "'and' and 'or' need conditions to stand between");
  EXPECT_EQ(refusal({}, {{.kind = Condition::Kind::nth, .number = std::uint64_t{0}}}),
            "samples are counted from the 1st on");
  for (const double deadband : {-1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(refusal({}, {{.kind = Condition::Kind::changed, .leaves = {1}, .number = deadband}}),
              "a deadband is a finite number from 0 on");
  }
  EXPECT_EQ(refusal({}, {{.kind = Condition::Kind::compare, .leaves = {1}, .number = std::nan("")}}),
            "a field is compared with a finite number");
  const Condition nth{.kind = Condition::Kind::nth, .number = std::uint64_t{2}};
  EXPECT_EQ(refusal({}, {nth, nth}), "conditions beside each other");
  const Condition pair{.kind = Condition::Kind::any_of, .children = 2};
  EXPECT_EQ(refusal({}, {pair, nth}), "'and' or 'or' lacks a condition");
  EXPECT_EQ(refusal({}, std::vector<Condition>(9, pair)), "conditions lie at most 8 deep in each other");
  std::vector<Part> many(17);
  for (std::uint32_t i = 0; i < many.size(); ++i) many[i] = {.leaf = i, .columns = {.begin = 1}};
  EXPECT_EQ(refusal(many), "parts of more than 16 fields");
  Part wordy{.leaf = 1};
  for (char c = 'a'; c < 'j'; ++c) wordy.channels.emplace_back(255, c);
  for (const char* name : {"a,b", "a}", " a", "a ", "a\nb", "\xff"})
    EXPECT_EQ(refusal({{.leaf = 1, .channels = {name}}}),
              "the name of a channel is printable, and has no ',', no '}' and no blank at its ends");
  EXPECT_EQ(refusal({{.leaf = 1, .channels = {"a b", "{", "\xc3\xa4"}}}), "");
  EXPECT_EQ(refusal({{.leaf = 1, .channels = std::vector<std::string>(65, "x")}}), "") << "it is one channel";
  EXPECT_EQ(refusal({wordy}), "it takes more than 2048 bytes; name fewer or shorter channels");
}

}  // namespace
}  // namespace sft
