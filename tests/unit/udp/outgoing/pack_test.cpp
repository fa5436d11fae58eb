// These tests check packs of small samples that share datagrams. A pack is cut into datagrams, and its
// samples are read from the datagrams again.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "tests/support/test_seed.h"
#include "tests/unit/udp/datagrams.h"
#include "udp_transport/outgoing/job.h"
#include "udp_transport/reliable/resend_window.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using Lengths = std::vector<std::size_t>;

class PackTest : public testing::Test {
 protected:
  // The low half of the sequence number wraps around after this sequence.
  static constexpr std::uint64_t first_sequence = 0x1'ffff'fffe;

  void pack(const Lengths& lengths) {
    job_ = JobPool::make()->take();
    job_->mask = std::make_shared<WireMask>(WireMask{3, 0xff, words_});
    job_->sequence = first_sequence;
    job_->first.label = {.writer = 1, .sequence = static_cast<std::uint32_t>(first_sequence), .variant = 3};
    job_->first.flags = words_.empty() ? std::uint8_t{0} : mask_words_follow;
    job_->first.mask = 0xff;
    for (std::size_t i = 0; i < lengths.size(); ++i) job_->pack(Bytes(lengths[i], static_cast<std::byte>(i)));
    job_->seal();
  }

  /// Reads the samples from a datagram. Expects consecutive sequences.
  void take(const Bytes& bytes) {
    auto d = parse(bytes);
    ASSERT_TRUE(d);
    ASSERT_EQ(d->kind, DatagramKind::packed);
    d->payload = d->payload.subspan(words_.size() * sizeof(std::uint64_t));
    PackedBodies bodies(*d);
    ASSERT_TRUE(bodies.sound());
    for (std::uint32_t i = 0; i < d->samples; ++i) {
      const auto body = bodies.next();
      const auto number = static_cast<std::uint32_t>(taken_.size());
      EXPECT_EQ(header_behind(d->first, i, 0).label.sequence,
                static_cast<std::uint32_t>(first_sequence + number));
      for (const std::byte b : body) ASSERT_EQ(b, static_cast<std::byte>(number));
      taken_.push_back(body.size());
    }
  }
  Lengths taken(std::size_t datagram_bytes) {
    taken_.clear();
    for (const Bytes& bytes : test::cut(job_->body(), datagram_bytes)) {
      EXPECT_LE(bytes.size(), datagram_bytes);
      take(bytes);
    }
    return taken_;
  }

  JobHandle job_;
  std::vector<std::uint64_t> words_;
  Lengths taken_;
};

TEST_F(PackTest, LaysOutItsHeaderAsDocumented) {
  std::array<std::byte, first_header_bytes> bytes;
  encode(PackedHeader{{.label = {.writer = 0x04030201, .sequence = 0x14131211, .variant = 0x0605},
                       .mask = 0x3837363534333231,
                       .stamp_ns = -2},
                      0x2221,
                      0x2423},
         bytes.data());
  Bytes expected;
  for (const unsigned byte :
       {0x25, 0,    0x05, 0x06, 0x01, 0x02, 0x03, 0x04, 0x11, 0x12, 0x13, 0x14, 0x21, 0x22, 0x23, 0x24,
        0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0x37, 0x38})
    expected.push_back(static_cast<std::byte>(byte));
  EXPECT_EQ(Bytes(bytes.begin(), bytes.end()), expected);
}

TEST_F(PackTest, HasNothingButBodiesWhereTheseAreEquallyLong) {
  pack(Lengths(50, 64));
  const auto datagrams = test::cut(job_->body(), 1472);
  ASSERT_EQ(datagrams.size(), 3U);
  EXPECT_EQ(datagrams[0].size(), job_->first.bytes() + 22 * 64);
  EXPECT_EQ(datagrams[2].size(), job_->first.bytes() + 6 * 64);
  EXPECT_EQ(taken(1472), Lengths(50, 64));
}

TEST_F(PackTest, FillsDatagramsOfOneCallToOneLengthWhereBodiesDiffer) {
  Lengths lengths;
  for (std::size_t i = 0; i < 100; ++i) lengths.push_back(i % 90);
  pack(lengths);
  const auto datagrams = test::cut(job_->body(), 600);
  ASSERT_GT(datagrams.size(), 5U);
  for (std::size_t i = 0; i + 1 < datagrams.size(); ++i) EXPECT_EQ(datagrams[i].size(), 600U);
  EXPECT_EQ(taken(600), lengths);
}

TEST_F(PackTest, NamesItsMaskInEachDatagram) {
  words_ = {5, 7};
  pack(Lengths(50, 64));
  EXPECT_EQ(taken(548), Lengths(50, 64));
}

TEST_F(PackTest, TakesRandomLengthsIntoAnyDatagrams) {
  std::mt19937_64 random(sft::test::test_seed());
  SCOPED_TRACE(sft::test::how_to_repeat());
  for (int round = 0; round < 200; ++round) {
    Lengths lengths(1 + random() % 600);
    for (std::size_t& length : lengths) length = round % 3 == 0 ? 1 + round : random() % 400;
    pack(lengths);
    EXPECT_EQ(taken(548 + random() % 9000), lengths);
  }
}

TEST_F(PackTest, IsRefusedWhereItIsNotWhatItSays) {
  pack({8, 8, 8});
  const Bytes sound = test::cut(job_->body(), 1472).at(0);
  for (std::size_t bytes = 0; bytes < sound.size(); ++bytes) {
    const auto d = parse(std::span(sound).first(bytes));
    EXPECT_FALSE(d && PackedBodies(*d).sound()) << bytes;
  }
  const auto with = [&](std::size_t at, unsigned value) {
    Bytes bytes = sound;
    bytes[at] = static_cast<std::byte>(value);
    const auto d = parse(bytes);
    return d && PackedBodies(*d).sound();
  };
  EXPECT_TRUE(with(12, 3));
  for (const unsigned samples : {0U, 2U, 4U}) EXPECT_FALSE(with(12, samples));
  EXPECT_FALSE(with(13, 2)) << "too many";
  for (const unsigned each : {0U, 7U, 9U}) EXPECT_FALSE(with(14, each));
  EXPECT_TRUE(with(1, narrow_mask));
  for (const unsigned flag : {rate_follows, history_follows, lengths_follow, group_follows, merged_masks})
    EXPECT_FALSE(with(1, flag | narrow_mask)) << flag;
}

TEST_F(PackTest, IsKeptAndRepairedSampleBySample) {
  ResendWindow::Time now{1h};
  ResendWindow window(1, 9, {.samples = 10});
  pack({4, 5, 6});
  EXPECT_EQ(window.keep(job_, job_->first).ordinal, 1U);
  const auto piece = window.take(1);
  ASSERT_TRUE(piece);
  EXPECT_EQ(piece->samples, 3U);
  window.finished(*piece, now);
  window.hear({.writer = 1, .channel = 9, .next = 2, .missing = {{{3, 0, 0}}}, .missing_count = 1}, now);
  EXPECT_EQ(window.kept(), 2U);
  EXPECT_EQ(window.kept_bytes(), 11U);
  const auto repair = window.next(ResendWindow::Size::small, now);
  ASSERT_TRUE(repair);
  const auto d = parse(test::cut(repair->body(), 1472).at(0));
  ASSERT_TRUE(d);
  EXPECT_EQ(d->kind, DatagramKind::first);
  EXPECT_EQ(d->first.channel, (ChannelMark{9, 2, 3})) << "its sequence has turned over";
  EXPECT_EQ(d->label().sequence, 0U);
  EXPECT_EQ(d->payload.size(), 6U);
}

}  // namespace
}  // namespace sft::udp
