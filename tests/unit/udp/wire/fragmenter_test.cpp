#include "udp_transport/wire/fragmenter.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "tests/support/test_seed.h"
#include "tests/unit/udp/datagrams.h"

namespace sft::udp {
namespace {

using namespace detail;

/// A body in several runs. It is cut into datagrams and assembled again.
class FragmenterTest : public testing::Test {
 protected:
  void body_of_runs(std::initializer_list<std::size_t> runs) {
    std::size_t total = 0;
    for (const std::size_t run : runs) total += run;
    bytes_.resize(total);
    for (std::size_t i = 0; i < total; ++i) bytes_[i] = static_cast<std::byte>(i * 7 + i / 256);
    segments_.clear();
    for (std::size_t at = 0; const std::size_t run : runs) {
      segments_.push_back({bytes_.data() + at, run});
      at += run;
    }
  }

  EncodedBody body() const {
    FirstHeader first{.label = {.writer = 1, .sequence = 2, .variant = 3},
                      .flags = 0,
                      .total = 0,
                      .mask = mask_,
                      .stamp_ns = 4};
    first.total = static_cast<std::uint32_t>(bytes_.size());
    first.flags = words_.empty() ? std::uint8_t{0} : mask_words_follow;
    return {first, words_, segments_};
  }

  void expect_the_body_in(const std::vector<test::Bytes>& datagrams) const {
    std::vector<std::byte> got;
    for (const test::Bytes& bytes : datagrams) {
      const auto d = parse(bytes);
      ASSERT_TRUE(d);
      EXPECT_EQ(d->label(), body().first.label);
      EXPECT_EQ(d->offset, got.size());
      const std::size_t words = got.empty() && d->kind == DatagramKind::first ? words_.size() * 8 : 0;
      got.insert(got.end(), d->payload.begin() + static_cast<std::ptrdiff_t>(words), d->payload.end());
    }
    EXPECT_EQ(got, bytes_);
  }

  std::vector<std::byte> bytes_;
  std::vector<Segment> segments_;
  std::vector<std::uint64_t> words_;
  std::uint64_t mask_ = UINT64_MAX;
};

TEST_F(FragmenterTest, PutsASmallBodyIntoOneDatagramAndOnePart) {
  body_of_runs({64});
  Batch batch;
  Fragmenter fragments(body(), 1472);
  fragments.next(batch);
  EXPECT_TRUE(fragments.done());
  EXPECT_EQ(batch.bytes(), single_header_bytes + 64);
  EXPECT_EQ(batch.parts().size(), 1U);
  EXPECT_EQ(batch.segment_bytes(), 0U);
}

TEST_F(FragmenterTest, SendsAnEmptyBodyAsAHeader) {
  body_of_runs({});
  const auto datagrams = test::cut(body(), 1472);
  ASSERT_EQ(datagrams.size(), 1U);
  EXPECT_EQ(datagrams[0].size(), single_header_bytes);
}

TEST_F(FragmenterTest, PutsABodyIntoASingleDatagramAsLongAsItFits) {
  body_of_runs({1472 - single_header_bytes});
  EXPECT_EQ(test::cut(body(), 1472).size(), 1U);
  body_of_runs({1472 - single_header_bytes + 1});
  const auto datagrams = test::cut(body(), 1472);
  EXPECT_EQ(datagrams.size(), 2U);
  expect_the_body_in(datagrams);
}

TEST_F(FragmenterTest, GivesTheRoomThatANarrowMaskLeavesToTheBody) {
  mask_ = 0xff;
  body_of_runs({1472 - single_header_bytes + 6});
  EXPECT_EQ(test::cut(body(), 1472).size(), 1U);
  body_of_runs({1472 - single_header_bytes + 7});
  const auto datagrams = test::cut(body(), 1472);
  EXPECT_EQ(datagrams.size(), 2U);
  EXPECT_EQ(datagrams[0].size(), 1472U);
  expect_the_body_in(datagrams);
}

TEST_F(FragmenterTest, FollowsInShortUpToSixteenMegabytesAndKeepsTheLengthBehindThem) {
  body_of_runs({near_offsets_end + 100'000});
  const auto datagrams = test::cut(body(), 8972);
  expect_the_body_in(datagrams);
  const auto is_far = [](const test::Bytes& bytes) { return kind_of(bytes) == DatagramKind::far; };
  const auto first_far = std::ranges::find_if(datagrams, is_far);
  ASSERT_NE(first_far, datagrams.end());
  EXPECT_GE(parse(*first_far)->offset, near_offsets_end);
  EXPECT_LT(parse(*(first_far - 1))->offset, near_offsets_end);
  EXPECT_TRUE(std::all_of(first_far, datagrams.end(), is_far));
  for (std::size_t i = 0; i + 1 < datagrams.size(); ++i) ASSERT_EQ(datagrams[i].size(), 8972U);
}

TEST_F(FragmenterTest, MakesAllDatagramsButTheLastEquallyLong) {
  body_of_runs({100'000});
  const auto datagrams = test::cut(body(), 1472);
  for (std::size_t i = 0; i + 1 < datagrams.size(); ++i) EXPECT_EQ(datagrams[i].size(), 1472U);
  EXPECT_LE(datagrams.back().size(), 1472U);
  expect_the_body_in(datagrams);
}

TEST_F(FragmenterTest, ReferencesLongRunsAndCopiesShortOnes) {
  body_of_runs({10, 5000, 20});
  Batch batch;
  Fragmenter fragments(body(), 9000);
  fragments.next(batch);
  ASSERT_EQ(batch.parts().size(), 3U);
  EXPECT_EQ(batch.parts()[0].iov_len, single_header_bytes + 10);
  EXPECT_EQ(batch.parts()[1].iov_base, bytes_.data() + 10);
  EXPECT_EQ(batch.parts()[2].iov_len, 20U);
}

TEST_F(FragmenterTest, KeepsBatchesWithinWhatOneCallTakes) {
  body_of_runs({1'000'000});
  for (const std::size_t datagram_bytes : {548U, 1472U, 8972U, 65507U}) {
    Batch batch;
    Fragmenter fragments(body(), datagram_bytes);
    while (!fragments.done()) {
      fragments.next(batch);
      EXPECT_LE(batch.bytes(), 65507U);
      EXPECT_LE(batch.datagrams(), 64U);
      EXPECT_LE(batch.parts().size(), 1024U);
    }
  }
}

TEST_F(FragmenterTest, ObeysTheLimitsOfACallButAlwaysProceeds) {
  body_of_runs({100'000});
  Batch batch;
  Fragmenter fragments(body(), 1472);
  fragments.next(batch, 5000);
  EXPECT_EQ(batch.datagrams(), 3U);
  fragments.next(batch, 1);
  EXPECT_EQ(batch.datagrams(), 1U);
  fragments.next(batch, 65507, 2);
  EXPECT_EQ(batch.datagrams(), 2U);
}

TEST_F(FragmenterTest, PutsTheWordsOfALongMaskBeforeThePayload) {
  body_of_runs({3000});
  words_ = {0x0102030405060708, 0x42};
  const auto datagrams = test::cut(body(), 1472);
  EXPECT_EQ(load_word(&datagrams[0][first_header_bytes]), 0x0102030405060708U);
  EXPECT_EQ(load_word(&datagrams[0][first_header_bytes + 8]), 0x42U);
  expect_the_body_in(datagrams);
}

TEST_F(FragmenterTest, CutsRandomRunsSoThatTheyFitTogether) {
  const std::uint64_t seed = sft::test::test_seed();
  SCOPED_TRACE(sft::test::how_to_repeat());
  std::mt19937 random(seed);
  for (int round = 0; round < 300; ++round) {
    const auto run = [&] { return std::size_t{random() % (random() % 4 == 0 ? 30'000U : 1500U)}; };
    body_of_runs({run(), run(), run(), run(), run()});
    expect_the_body_in(test::cut(body(), 548 + random() % 9000));
  }
}

}  // namespace
}  // namespace sft::udp
