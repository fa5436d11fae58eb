#include "sft/mask.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <ranges>
#include <set>
#include <vector>

#include "tests/support/test_seed.h"

namespace sft {
namespace {

TEST(FieldMaskTest, AFullMaskHasEveryLeafAndNoBitBeyond) {
  for (const std::size_t leaves : {1U, 63U, 64U, 65U, 128U, 200U}) {
    const FieldMask full = FieldMask::full(leaves);
    EXPECT_EQ(full.size(), leaves);
    EXPECT_TRUE(full.is_full());
    EXPECT_EQ(full, FieldMask::from_words(leaves, std::vector<std::uint64_t>(8, ~std::uint64_t{0})));
  }
}

TEST(FieldMaskTest, WordsThatAreMissingAreEmpty) {
  const FieldMask mask = FieldMask::from_words(100, std::vector<std::uint64_t>{2});
  EXPECT_EQ(mask.size(), 1U);
  EXPECT_TRUE(mask.contains(1));
}

TEST(FieldMaskTest, EqualMasksHashAlikeAndUpTo64LeavesTheHashIsTheBits) {
  FieldMask small(10);
  small.insert(3);
  EXPECT_EQ(small.hash(), 8U);
  FieldMask a(130);
  FieldMask b(130);
  a.insert(129);
  EXPECT_NE(a.hash(), b.hash());
  b.insert(129);
  EXPECT_EQ(a.hash(), b.hash());
}

TEST(FieldMaskTest, TheNextLeafIsTheLowestOneWithinTheRange) {
  for (const std::size_t leaves : {64U, 200U}) {
    FieldMask mask(leaves);
    for (const std::size_t leaf : {0U, 5U, 63U}) mask.insert(leaf);
    mask.insert(leaves - 1);
    for (std::size_t first = 0; first < leaves; ++first) {
      for (std::size_t end = 0; end <= leaves; ++end) {
        std::size_t expected = first;
        while (expected < end && !mask.contains(expected)) ++expected;
        ASSERT_EQ(mask.next(first, end), first < end ? expected : end) << first << " to " << end;
      }
    }
  }
}

std::vector<std::size_t> numbers(const FieldMask& mask) { return {mask.begin(), mask.end()}; }

template <class Algorithm>
std::vector<std::size_t> combined(const std::set<std::size_t>& a, const std::set<std::size_t>& b,
                                  Algorithm algorithm) {
  std::vector<std::size_t> result;
  algorithm(a, b, std::back_inserter(result));
  return result;
}

static_assert(std::ranges::forward_range<FieldMask>);

TEST(FieldMaskTest, BehavesLikeASetOfNumbers) {
  SCOPED_TRACE("to repeat: SFT_TEST_SEED=" + std::to_string(test::test_seed()));
  test::Random random(test::test_seed());
  for (int round = 0; round < 500; ++round) {
    const std::size_t leaves = 1 + random() % 200;
    FieldMask mask(leaves);
    FieldMask other(leaves);
    std::set<std::size_t> model;
    std::set<std::size_t> other_model;
    for (int i = 0; i < 40; ++i) {
      const std::size_t leaf = random() % leaves;
      random() % 3 == 0 ? (mask.erase(leaf), model.erase(leaf))
                        : (mask.insert(leaf), model.insert(leaf).second);
      if (random() % 2 == 0) {
        other.insert(leaf);
        other_model.insert(leaf);
      }
    }
    const std::size_t first = random() % leaves;
    const std::size_t count = random() % (leaves - first + 1);
    std::size_t within = 0;
    for (const std::size_t leaf : model) within += leaf >= first && leaf < first + count ? 1 : 0;
    ASSERT_EQ(mask.size(), model.size());
    ASSERT_EQ(mask.empty(), model.empty());
    ASSERT_EQ(mask.any_of(first, count), within > 0);
    ASSERT_EQ(mask.all_of(first, count), within == count);
    ASSERT_EQ(mask.contains(other),
              std::includes(model.begin(), model.end(), other_model.begin(), other_model.end()));
    ASSERT_EQ(mask.intersects(other), !(mask & other).empty());
    ASSERT_TRUE(std::ranges::equal(mask, model));
    ASSERT_EQ(numbers(mask | other), combined(model, other_model, std::ranges::set_union));
    ASSERT_EQ(numbers(mask & other), combined(model, other_model, std::ranges::set_intersection));
    ASSERT_EQ(numbers(mask - other), combined(model, other_model, std::ranges::set_difference));
    ASSERT_EQ(numbers(mask ^ other), combined(model, other_model, std::ranges::set_symmetric_difference));
    ASSERT_EQ(~mask, FieldMask::full(leaves) - mask);
    ASSERT_EQ(~~mask, mask);
  }
}

}  // namespace
}  // namespace sft
