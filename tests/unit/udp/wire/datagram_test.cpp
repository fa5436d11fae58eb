#include "udp_transport/wire/datagram.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "tests/support/test_seed.h"

namespace sft::udp {
namespace {

using test::numbers_of;

constexpr std::uint64_t wide_mask = 0x1'0000;  // the smallest mask that takes eight bytes
constexpr SampleLabel label{.writer = 0x04030201, .sequence = 0x14131211, .variant = 0x0605};

TEST(Datagram, LaysOutTheFirstHeaderAsDocumented) {
  std::array<std::byte, first_header_bytes> bytes;
  encode(
      FirstHeader{
          .label = label, .flags = 1, .total = 0x24232221, .mask = 0x3837363534333231, .stamp_ns = -2},
      bytes.data());
  EXPECT_EQ(numbers_of(bytes),
            (std::vector<unsigned>{0x21, 1,    0x05, 0x06, 0x01, 0x02, 0x03, 0x04, 0x11, 0x12, 0x13,
                                   0x14, 0x21, 0x22, 0x23, 0x24, 0xfe, 0xff, 0xff, 0xff, 0xff, 0xff,
                                   0xff, 0xff, 0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0x37, 0x38}));
}

TEST(Datagram, HasTwoBytesOfAMaskThatHasNoMore) {
  std::array<std::byte, first_header_bytes> bytes{};
  FirstHeader header{.label = label, .total = 0x24232221, .mask = 0xffff, .stamp_ns = -2};
  ASSERT_EQ(header.bytes(), 26U);
  encode(header, bytes.data());
  EXPECT_EQ(numbers_of(bytes),
            (std::vector<unsigned>{0x21, 32,   0x05, 0x06, 0x01, 0x02, 0x03, 0x04, 0x11, 0x12, 0x13,
                                   0x14, 0x21, 0x22, 0x23, 0x24, 0xfe, 0xff, 0xff, 0xff, 0xff, 0xff,
                                   0xff, 0xff, 0xff, 0xff, 0,    0,    0,    0,    0,    0}));
  const auto d = parse(std::span(bytes).first(header.bytes()));
  ASSERT_TRUE(d);
  EXPECT_EQ(d->first.mask, 0xffffU);
  EXPECT_EQ(d->first.flags, 0) << "the flag is on the wire only";
  EXPECT_FALSE(parse(std::span(bytes).first(header.bytes() - 1)));
  header.mask = 0x1'0000;
  EXPECT_EQ(header.bytes(), 32U);
  encode(header, bytes.data());
  EXPECT_EQ(bytes[1], std::byte{0});
  EXPECT_EQ(parse(bytes)->first.mask, 0x1'0000U);
}

TEST(Datagram, IsRefusedIfAMaskHasMoreBytesThanItNeeds) {
  std::array<std::byte, 64> bytes{};
  FirstHeader header = {.label = label, .mask = 0x1'0000};
  const auto is_read_with_the_mask = [&](std::size_t at) {
    bytes[at + 2] = std::byte{0};
    return parse(bytes).has_value();
  };
  encode(header, bytes.data());
  EXPECT_FALSE(is_read_with_the_mask(24));
  encode_in_single(header, bytes.data());
  EXPECT_FALSE(is_read_with_the_mask(20));
  header.flags = channel_follows;
  header.channel = {.channel = 1, .ordinal = 1, .in_short = true};
  encode_in_short(header, bytes.data());
  EXPECT_FALSE(is_read_with_the_mask(24));
}

TEST(Datagram, LaysOutTheFollowingHeaderAsDocumented) {
  std::array<std::byte, following_header_bytes> bytes;
  SampleLabel near = label;
  near.variant = 0xfe;
  encode(FollowingHeader{.label = near, .offset = 0x232221}, bytes.data());
  EXPECT_EQ(numbers_of(bytes), (std::vector<unsigned>{0x22, 0xfe, 0x01, 0x02, 0x03, 0x04, 0x11, 0x12, 0x13,
                                                      0x14, 0x21, 0x22, 0x23}));
}

TEST(Datagram, LaysOutTheFarHeaderAsDocumented) {
  std::array<std::byte, far_header_bytes> bytes;
  encode(FollowingHeader{.label = label, .offset = 0x24232221}, bytes.data());
  EXPECT_EQ(numbers_of(bytes), (std::vector<unsigned>{0x2d, 0, 0x05, 0x06, 0x01, 0x02, 0x03, 0x04, 0x11, 0x12,
                                                      0x13, 0x14, 0x21, 0x22, 0x23, 0x24}));
}

TEST(Datagram, FollowsInShortUpToTheLastVariantAndOffsetForWhichThereIsRoom) {
  for (const std::uint16_t variant : {0, 255, 256, 65535}) {
    for (const std::uint32_t offset : {0U, 0xff'ffffU, 0x100'0000U, UINT32_MAX - 1}) {
      SampleLabel of = label;
      of.variant = variant;
      const FollowingHeader header{of, offset};
      const bool is_far = variant > 255 || offset > 0xff'ffff;
      ASSERT_EQ(header.bytes(), is_far ? 16U : 13U) << variant << " " << offset;
      std::array<std::byte, far_header_bytes + 1> bytes{};
      encode(header, bytes.data());
      EXPECT_EQ(kind_of(bytes), is_far ? DatagramKind::far : DatagramKind::following);
      const auto sent = std::span(bytes).first(header.bytes() + 1);
      const auto read = parse_as<Following>(sent);
      ASSERT_TRUE(read) << variant << " " << offset;
      EXPECT_EQ(read->label, of);
      EXPECT_EQ(read->offset, offset);
      EXPECT_EQ(read->payload.size(), 1U);
      EXPECT_EQ(read->payload.data(), &bytes[header.bytes()]);
    }
  }
}

TEST(Datagram, ReadsWhatItWrote) {
  const FirstHeader sent{.label = label, .flags = 0, .total = 9, .mask = 5, .stamp_ns = -2};
  std::vector<std::byte> bytes(sent.bytes() + 3);
  encode(sent, bytes.data());
  const auto d = parse(bytes);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->kind, DatagramKind::first);
  EXPECT_EQ(d->label(), label);
  EXPECT_EQ(d->first.total, 9U);
  EXPECT_EQ(d->first.mask, 5U);
  EXPECT_EQ(d->first.stamp_ns, -2);
  EXPECT_EQ(d->payload.size(), 3U);
  EXPECT_EQ(d->payload.data(), &bytes[sent.bytes()]);
}

TEST(Datagram, CarriesTheRateBehindTheFirstHeaderOnlyWhereThereIsOne) {
  std::array<std::byte, first_header_bytes + rate_bytes + 3> bytes{};
  FirstHeader header{.label = label, .flags = rate_follows, .total = 9, .mask = wide_mask};
  header.rate = {.min_period_us = 100'000, .ordinal = 7};
  encode(header, bytes.data());
  EXPECT_EQ(header.bytes(), 40U);
  EXPECT_EQ(std::to_integer<unsigned>(bytes[36]), 7U);
  const auto d = parse(bytes);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->first.rate, header.rate);
  EXPECT_EQ(d->payload.size(), 3U);
  EXPECT_FALSE(parse(std::span(bytes).first(39)));
  header.flags = 0;
  EXPECT_EQ(header.bytes(), 32U);
}

TEST(Datagram, CarriesTheMarkOfARetainedSampleBehindTheRate) {
  std::array<std::byte, first_header_bytes + rate_bytes + history_bytes + 1> bytes{};
  FirstHeader header{.label = label, .flags = rate_follows | history_follows, .mask = wide_mask};
  header.rate = {.min_period_us = 100'000, .ordinal = 7};
  header.history = {.reader = 0x1'0000'0002, .oldest = 9};
  encode(header, bytes.data());
  EXPECT_EQ(header.bytes(), 56U);
  const auto d = parse(bytes);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->first.rate, header.rate);
  EXPECT_EQ(d->first.history, header.history);
  EXPECT_EQ(d->payload.size(), 1U);
  EXPECT_FALSE(parse(std::span(bytes).first(55)));
  header.history.reader = 0;
  encode(header, bytes.data());
  EXPECT_FALSE(parse(bytes)) << "for nobody";
}

TEST(Datagram, CarriesItsPlaceInAChannelBehindAllOthers) {
  std::array<std::byte, first_header_bytes + history_bytes + channel_bytes + 1> bytes{};
  FirstHeader header{.label = label, .flags = history_follows | channel_follows, .mask = wide_mask};
  header.history = {.reader = 1, .oldest = 9};
  header.channel = {.channel = 3, .sequence_high = 5, .ordinal = 0x1'0000'0007};
  encode(header, bytes.data());
  EXPECT_EQ(header.bytes(), 64U);
  const auto d = parse(bytes);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->first.channel, header.channel);
  EXPECT_EQ(d->payload.size(), 1U);
  EXPECT_FALSE(parse(std::span(bytes).first(63)));
  header.channel.ordinal = 0;
  encode(header, bytes.data());
  EXPECT_FALSE(parse(bytes)) << "ordinals count from 1";
}

TEST(Heartbeat, CarriesWholeOrdinals) {
  std::array<std::byte, heartbeat_bytes> bytes{};
  const Heartbeat sent{.writer = 1,
                       .channel = 2,
                       .port = 3,
                       .first = 0x1'0000'0004,
                       .end = 0x2'0000'0005,
                       .waiting = 0xfedc'ba98};
  encode(sent, bytes.data());
  EXPECT_EQ(kind_of(bytes), DatagramKind::heartbeat);
  EXPECT_EQ(parse_as<Heartbeat>(bytes), sent);
  EXPECT_FALSE(parse(bytes)) << "it is of no sample";
  EXPECT_FALSE(parse_as<Ack>(bytes));
}

TEST(Heartbeat, IsRefusedWhenItCannotBeTrue) {
  const auto parses = [](Heartbeat heartbeat, std::size_t bytes_sent = heartbeat_bytes) {
    std::array<std::byte, heartbeat_bytes + 1> bytes{};
    encode(heartbeat, bytes.data());
    return parse_as<Heartbeat>(std::span(bytes).first(bytes_sent)).has_value();
  };
  EXPECT_TRUE(parses({.port = 1, .first = 7, .end = 7}));
  EXPECT_FALSE(parses({.port = 1, .first = 7, .end = 6})) << "ends before it begins";
  EXPECT_FALSE(parses({.port = 1, .first = 0, .end = 7})) << "ordinals count from 1";
  EXPECT_FALSE(parses({.port = 0, .first = 7, .end = 7})) << "nowhere to answer";
  EXPECT_FALSE(parses({.port = 1, .first = 7, .end = UINT64_MAX}));
  EXPECT_FALSE(parses({.port = 1, .first = 7, .end = 7}, heartbeat_bytes - 1));
  EXPECT_FALSE(parses({.port = 1, .first = 7, .end = 7}, heartbeat_bytes + 1));
}

TEST(FlowMark, ComesBackAsItWas) {
  const FlowMark sent{.flow = 1, .port = 2, .position = 0x1'0000'0003, .datagrams = 4, .sent_at_ns = 5};
  std::vector<std::byte> bytes(mark_bytes);
  encode(sent, bytes.data());
  EXPECT_EQ(parse_as<FlowMark>(bytes), sent);
  EXPECT_FALSE(parse_as<FlowReport>(bytes)) << "it is none";
  for (std::size_t n = 0; n < bytes.size(); ++n)
    EXPECT_FALSE(parse_as<FlowMark>(std::span(bytes).first(n))) << n;
  encode(FlowMark{.port = 0}, bytes.data());
  EXPECT_FALSE(parse_as<FlowMark>(bytes)) << "nowhere to answer";
}

TEST(FlowReport, ComesBackAsItWasAndIsNoLongerThanTheMark) {
  const FlowReport sent{.flow = 1,
                        .position = 0x1'0000'0003,
                        .window_bytes = 4,
                        .datagrams = 5,
                        .came = 6,
                        .longest = 8,
                        .sent_at_ns = 0x7'0000'0007};
  std::vector<std::byte> bytes(report_bytes);
  encode(sent, bytes.data());
  EXPECT_EQ(parse_as<FlowReport>(bytes), sent);
  EXPECT_FALSE(parse_as<FlowMark>(bytes)) << "it is none";
  EXPECT_LE(report_bytes, mark_bytes) << "strangers could make others send more than they send themselves";
  for (std::size_t n = 0; n < bytes.size(); ++n)
    EXPECT_FALSE(parse_as<FlowReport>(std::span(bytes).first(n))) << n;
}

TEST(Ack, CarriesWhatIsMissing) {
  Ack sent{.writer = 1, .channel = 2, .next = 0x1'0000'0004, .missing_count = missing_max};
  for (std::uint32_t i = 0; i < missing_max; ++i) sent.missing[i] = {i, 10 * i, 10 * i + 5};
  std::vector<std::byte> bytes(sent.bytes());
  encode(sent, bytes.data());
  EXPECT_LE(bytes.size(), datagram_bytes_min);
  const auto ack = parse_as<Ack>(bytes);
  ASSERT_TRUE(ack);
  EXPECT_EQ(ack->writer, 1U);
  EXPECT_EQ(ack->channel, 2U);
  EXPECT_EQ(ack->next, 0x1'0000'0004U);
  EXPECT_EQ(ack->missing, sent.missing);
  for (std::size_t n = 0; n < bytes.size(); ++n) EXPECT_FALSE(parse_as<Ack>(std::span(bytes).first(n))) << n;
  bytes.push_back({});
  EXPECT_FALSE(parse_as<Ack>(bytes));
}

TEST(Ack, IsRefusedWhenARangeEndsBeforeItBegins) {
  Ack ack{.next = 1, .missing = {{{1, 5, 4}}}, .missing_count = 1};
  std::vector<std::byte> bytes(ack.bytes());
  encode(ack, bytes.data());
  EXPECT_FALSE(parse_as<Ack>(bytes));
}

TEST(Datagram, CarriesTheNumberInAGateThatHasConditionsAndNoRate) {
  const FirstHeader header{.label = label, .flags = rate_follows, .rate = {.ordinal = 7}};
  std::vector<std::byte> bytes(header.bytes());
  encode(header, bytes.data());
  const auto datagram = parse(bytes);
  ASSERT_TRUE(datagram);
  EXPECT_EQ(datagram->first.rate, (RateMark{.min_period_us = 0, .ordinal = 7}));
}

class BrokenDatagram : public testing::Test {
 protected:
  std::vector<std::byte> first() const {
    const FirstHeader header{.label = label, .flags = 0, .total = 0, .mask = wide_mask, .stamp_ns = 0};
    std::vector<std::byte> bytes(header.bytes());
    encode(header, bytes.data());
    return bytes;
  }
  std::vector<std::byte> following(std::uint32_t offset, std::size_t payload) const {
    SampleLabel near = label;
    near.variant = 1;
    const FollowingHeader header{near, offset};
    std::vector<std::byte> bytes(header.bytes() + payload);
    encode(header, bytes.data());
    return bytes;
  }
};

TEST_F(BrokenDatagram, IsRefusedWhenTooShortForItsHeader) {
  const auto whole = first();
  for (std::size_t n = 0; n < whole.size(); ++n) EXPECT_FALSE(parse(std::span(whole).first(n))) << n;
  EXPECT_TRUE(parse(whole));
}

TEST_F(BrokenDatagram, IsRefusedWhenOfAnotherVersionOrKind) {
  for (unsigned byte = 0; byte < 256; ++byte) {
    auto bytes = first();
    bytes[0] = static_cast<std::byte>(byte);
    EXPECT_EQ(parse(bytes).has_value(), byte == 0x21 || byte == 0x22 || byte == 0x2c || byte == 0x2d) << byte;
  }
}

TEST_F(BrokenDatagram, IsRefusedWhenAFlagIsNotKnown) {
  auto bytes = first();
  bytes[1] = std::byte{16};
  EXPECT_FALSE(parse(bytes));
  auto far = following(near_offsets_end, 1);
  EXPECT_TRUE(parse(far));
  far[1] = std::byte{1};
  EXPECT_FALSE(parse(far));
}

TEST_F(BrokenDatagram, IsRefusedWhenAFollowingOneCarriesNothing) {
  EXPECT_FALSE(parse(following(8, 0)));
  EXPECT_FALSE(parse(following(near_offsets_end, 0)));
}

TEST_F(BrokenDatagram, IsRefusedWhenItsEndOverflows) {
  EXPECT_FALSE(parse(following(UINT32_MAX, 1)));
  EXPECT_TRUE(parse(following(UINT32_MAX - 1, 1)));
}

TEST_F(BrokenDatagram, IsRefusedWhenLongerThanUdpAllows) {
  EXPECT_TRUE(parse(following(0, datagram_bytes_max - following_header_bytes)));
  EXPECT_FALSE(parse(following(0, datagram_bytes_max - following_header_bytes + 1)));
}

TEST(WidenSequence, FindsTheNearest) {
  EXPECT_EQ(widen_sequence(0, 1), 1U);
  EXPECT_EQ(widen_sequence(10, 9), 9U);
  EXPECT_EQ(widen_sequence(0xffff'ffff, 0), 0x1'0000'0000U);
  EXPECT_EQ(widen_sequence(0x1'0000'0000, 0xffff'ffff), 0xffff'ffffU);
  EXPECT_EQ(widen_sequence(0x5'0000'0010, 0x20), 0x5'0000'0020U);
}

TEST(WidenSequence, NeverGoesBelowZero) {
  EXPECT_EQ(widen_sequence(0, 0xffff'ffff), 0xffff'ffffU);
  EXPECT_EQ(widen_sequence(5, 0x8000'0010), 0x8000'0010U);
}

TEST(WidenSequence, FollowsACounterThroughManyTurns) {
  const std::uint64_t seed = sft::test::test_seed();
  SCOPED_TRACE(sft::test::how_to_repeat());
  std::mt19937_64 random(seed);
  std::uint64_t sequence = 1;
  for (int i = 0; i < 100'000; ++i) {
    const std::uint64_t next = sequence + random() % 0x7fff'ffff;
    ASSERT_EQ(widen_sequence(sequence, static_cast<std::uint32_t>(next)), next);
    sequence = next;
  }
}

TEST(Datagram, CarriesARateAndThePlaceInAGroup) {
  FirstHeader header{.label = label, .flags = rate_follows | group_follows, .total = 3, .mask = wide_mask};
  header.rate = {.min_period_us = 0x34333231, .ordinal = 7};
  header.group = {.group = 0x44434241, .sequence_high = 9, .ordinal = 8};
  std::array<std::byte, first_header_bytes + rate_bytes + group_bytes + 3> bytes{};
  encode(header, bytes.data());
  EXPECT_EQ(bytes[first_header_bytes], std::byte{0x31});
  EXPECT_EQ(bytes[first_header_bytes + rate_bytes], std::byte{0x41});
  const auto d = parse(bytes);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->first.rate, header.rate);
  EXPECT_EQ(d->first.group, header.group);
  EXPECT_EQ(d->payload.size(), 3U);
}

TEST(Datagram, CarriesThePlaceInAGroup) {
  FirstHeader header{.label = label, .flags = group_follows | merged_masks, .total = 3, .mask = wide_mask};
  header.group = {.group = 0x44434241, .sequence_high = 0x54535251, .ordinal = 0x0867666564636261};
  std::array<std::byte, first_header_bytes + group_bytes + 3> bytes{};
  encode(header, bytes.data());
  EXPECT_EQ(bytes[first_header_bytes], std::byte{0x41});
  EXPECT_EQ(bytes[first_header_bytes + 15], std::byte{0x08});
  const auto d = parse(bytes);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->first.group, header.group);
  EXPECT_EQ(d->first.flags, header.flags);
  EXPECT_EQ(d->payload.size(), 3U);
  for (const std::uint8_t other : {history_follows, channel_follows}) {
    header.flags = group_follows | other;
    header.history = {1, 1};
    header.channel.ordinal = 1;
    std::array<std::byte, 128> both{};
    encode(header, both.data());
    EXPECT_FALSE(parse(both)) << int{other};
  }
  header.flags = group_follows;
  header.group.ordinal = 0;
  encode(header, bytes.data());
  EXPECT_FALSE(parse(bytes));
}

TEST(Datagram, CarriesOffersOfGroupsAndReports) {
  const GroupOffer offer{.writer = 1,
                         .group = 2,
                         .member = 3,
                         .port = 4,
                         .address = private_groups | 5,
                         .channel = 6,
                         .ahead = -7};
  std::array<std::byte, group_offer_bytes> bytes{};
  encode(offer, bytes.data());
  EXPECT_EQ(kind_of(bytes), DatagramKind::group_offer);
  EXPECT_EQ(parse_as<GroupOffer>(bytes), offer);
  EXPECT_FALSE(parse(bytes));
  const GroupReport report{.writer = 1, .group = 2, .member = 3, .heard = 4};
  std::array<std::byte, group_report_bytes> answer{};
  encode(report, answer.data());
  EXPECT_EQ(parse_as<GroupReport>(answer), report);
  EXPECT_FALSE(parse_as<GroupReport>(bytes));
  EXPECT_FALSE(parse_as<GroupOffer>(std::span(bytes).first(group_offer_bytes - 1)));
}

TEST(Datagram, CarriesProbesOfGroups) {
  const GroupProbe probe{.writer = 1, .group = 2, .ordinal = 3};
  std::array<std::byte, group_probe_bytes> bytes{};
  encode(probe, bytes.data());
  EXPECT_EQ(kind_of(bytes), DatagramKind::group_probe);
  EXPECT_EQ(parse_as<GroupProbe>(bytes), probe);
  EXPECT_FALSE(parse_as<GroupReport>(bytes));
  EXPECT_FALSE(parse_as<GroupProbe>(std::span(bytes).first(group_probe_bytes - 1)));
  for (const std::uint64_t ordinal : {std::uint64_t{0}, ordinal_max + 1}) {
    encode(GroupProbe{.writer = 1, .group = 2, .ordinal = ordinal}, bytes.data());
    EXPECT_FALSE(parse_as<GroupProbe>(bytes)) << ordinal;
  }
}

TEST(Datagram, RefusesOffersOfGroupsThatAreNotPrivate) {
  std::array<std::byte, group_offer_bytes> bytes{};
  const auto accepted = [&](GroupOffer offer) {
    encode(offer, bytes.data());
    return parse_as<GroupOffer>(bytes).has_value();
  };
  GroupOffer offer{.writer = 1, .group = 2, .member = 3, .port = 4, .address = 0, .channel = 6, .ahead = 0};
  EXPECT_TRUE(accepted(offer)) << "it takes a group back";
  for (const std::uint32_t address : {0xE0000001U, 0xEFFE0001U, 0x0A000001U, UINT32_MAX}) {
    offer.address = address;
    EXPECT_FALSE(accepted(offer)) << address;
  }
  offer = {.writer = 1, .group = 2, .member = 3, .port = 0, .address = 0, .channel = 6, .ahead = 0};
  EXPECT_FALSE(accepted(offer)) << "nobody could answer";
  offer.port = 4;
  offer.ahead = INT64_MIN;
  EXPECT_FALSE(accepted(offer));
}

}  // namespace
}  // namespace sft::udp
