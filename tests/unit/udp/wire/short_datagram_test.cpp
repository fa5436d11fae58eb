// These tests check the two formats for samples that fit into one datagram: single and whole datagrams.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {
namespace {

using test::numbers_of;

constexpr SampleLabel single_label{.writer = 0x04030201, .sequence = 0x14131211, .variant = 0x0605};

void expect_equal(const FirstHeader& read, const FirstHeader& sent) {
  EXPECT_EQ(read.label, sent.label);
  EXPECT_EQ(read.flags, sent.flags);
  EXPECT_EQ(read.total, sent.total);
  EXPECT_EQ(read.mask, sent.mask);
  EXPECT_EQ(read.stamp_ns, sent.stamp_ns);
  EXPECT_EQ(read.rate, sent.rate);
  EXPECT_EQ(read.history, sent.history);
  EXPECT_EQ(read.channel.channel, sent.channel.channel);
  EXPECT_EQ(read.channel.sequence_high, sent.channel.sequence_high);
  EXPECT_EQ(read.channel.ordinal, sent.channel.ordinal);
  EXPECT_EQ(read.group, sent.group);
}

TEST(SingleDatagram, IsLaidOutAsDocumented) {
  std::array<std::byte, single_header_bytes> bytes;
  encode_in_single(FirstHeader{.label = single_label,
                               .flags = 128,
                               .total = 0x24232221,
                               .mask = 0x3837363534333231,
                               .stamp_ns = -2},
                   bytes.data());
  EXPECT_EQ(numbers_of(bytes),
            (std::vector<unsigned>{0x2c, 128,  0x05, 0x06, 0x01, 0x02, 0x03, 0x04, 0x11, 0x12,
                                   0x13, 0x14, 0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,
                                   0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0x37, 0x38}));
}

TEST(SingleDatagram, IsReadAsTheFirstOneOfASampleThatHasNoOther) {
  for (const std::uint8_t flags : {std::uint8_t{0}, merged_masks}) {
    for (const std::uint64_t mask : {std::uint64_t{5}, std::uint64_t{0x1'0000}}) {
      const FirstHeader sent{.label = single_label, .flags = flags, .total = 3, .mask = mask, .stamp_ns = -2};
      ASSERT_TRUE(fits_in_single(sent));
      ASSERT_EQ(sent.bytes_in_single(), mask == 5 ? 22U : 28U);
      std::vector<std::byte> bytes(sent.bytes_in_single() + 3);
      encode_in_single(sent, bytes.data());
      const auto d = parse(bytes);
      ASSERT_TRUE(d);
      EXPECT_EQ(d->kind, DatagramKind::first);
      expect_equal(d->first, sent);
      EXPECT_EQ(d->payload.data(), &bytes[sent.bytes_in_single()]);
      EXPECT_EQ(d->payload.size(), 3U);
    }
  }
}

TEST(SingleDatagram, IsRefusedIfItEndsBeforeItsHeaderDoes) {
  for (const std::uint64_t mask : {std::uint64_t{5}, UINT64_MAX}) {
    const FirstHeader header{.label = single_label, .mask = mask};
    std::vector<std::byte> bytes(header.bytes_in_single());
    encode_in_single(header, bytes.data());
    for (std::size_t n = 0; n < bytes.size(); ++n) EXPECT_FALSE(parse(std::span(bytes).first(n))) << n;
    EXPECT_TRUE(parse(bytes));
  }
}

TEST(SingleDatagram, HasNoMarksAndIsRefusedIfItNamesSome) {
  std::array<std::byte, single_header_bytes + 64> bytes{};
  encode_in_single(FirstHeader{.label = single_label, .mask = UINT64_MAX}, bytes.data());
  for (unsigned flag = 1; flag < merged_masks; flag *= 2) {
    EXPECT_FALSE(fits_in_single({.label = single_label, .flags = static_cast<std::uint8_t>(flag)})) << flag;
    bytes[1] = static_cast<std::byte>(flag);
    // The flag narrow_mask determines the length of the mask.
    EXPECT_EQ(parse(bytes).has_value(), flag == narrow_mask) << flag;
  }
}

/// Returns the header of a sample that fits into a whole datagram.
FirstHeader whole_header() {
  return {.label = {.writer = 0x04030201, .sequence = 0x14131211, .variant = 0x155},
          .flags = channel_follows,
          .total = 3,
          .mask = 0x3837363534333231,
          .stamp_ns = -2,
          .channel = {.channel = 0x2aa, .ordinal = 0x24232221, .in_short = true}};
}

TEST(WholeDatagram, IsLaidOutAsDocumented) {
  std::array<std::byte, first_header_bytes> bytes;
  encode_in_short(whole_header(), bytes.data());
  EXPECT_EQ(numbers_of(bytes),
            (std::vector<unsigned>{0x2a, 0xa8, 0x4a, 0x55, 0x01, 0x02, 0x03, 0x04, 0x11, 0x12, 0x13,
                                   0x14, 0x21, 0x22, 0x23, 0x24, 0xfe, 0xff, 0xff, 0xff, 0xff, 0xff,
                                   0xff, 0xff, 0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0x37, 0x38}));
  FirstHeader flagged = whole_header();
  flagged.flags |= mask_words_follow;
  encode_in_short(flagged, bytes.data());
  EXPECT_EQ(bytes[1], std::byte{0xa9});
  flagged.flags = channel_follows | merged_masks;
  encode_in_short(flagged, bytes.data());
  EXPECT_EQ(bytes[1], std::byte{0xaa});
  flagged.mask = 0x3231;
  encode_in_short(flagged, bytes.data());
  EXPECT_EQ(bytes[1], std::byte{0xae});
  EXPECT_EQ(flagged.bytes_in_short(), 26U);
}

TEST(WholeDatagram, SaysWhatAFirstOneWouldSay) {
  constexpr std::uint16_t last_variant = whole_variants_end - 1;
  for (const std::uint8_t flags : {0, 1, 128, 129}) {
    for (const std::uint16_t variant : {std::uint16_t{0}, std::uint16_t{1}, last_variant}) {
      for (const std::uint32_t channel : {0U, 1U, whole_channels_end - 1}) {
        for (const std::uint64_t ordinal : {1ULL, 0xffff'ffffULL}) {
          FirstHeader sent = whole_header();
          sent.flags |= flags;
          sent.label.variant = variant;
          sent.channel = {.channel = channel, .ordinal = ordinal, .in_short = true};
          sent.mask = variant == 1 ? 0x3231 : sent.mask;
          ASSERT_TRUE(fits_in_short(sent));
          std::vector<std::byte> in_short(sent.bytes_in_short() + 3);
          encode_in_short(sent, in_short.data());
          std::vector<std::byte> at_length(sent.bytes() + 3);
          encode(sent, at_length.data());
          const auto d = parse(in_short);
          const auto long_form = parse(at_length);
          ASSERT_TRUE(d && long_form);
          EXPECT_EQ(d->kind, DatagramKind::whole);
          expect_equal(d->first, sent);
          expect_equal(long_form->first, sent);
          EXPECT_EQ(d->payload.data(), &in_short[sent.bytes_in_short()]);
          EXPECT_EQ(d->payload.size(), 3U);
        }
      }
    }
  }
}

TEST(WholeDatagram, HasNoRoomForWhatOnlyAFirstOneCanSay) {
  EXPECT_TRUE(fits_in_short(whole_header()));
  const auto fits = [](auto change) {
    FirstHeader header = whole_header();
    change(header);
    return fits_in_short(header);
  };
  EXPECT_FALSE(fits([](FirstHeader& h) { h.flags = 0; })) << "it is in no channel";
  EXPECT_FALSE(fits([](FirstHeader& h) { h.flags = merged_masks; }));
  EXPECT_FALSE(fits([](FirstHeader& h) { h.flags |= rate_follows; }));
  EXPECT_FALSE(fits([](FirstHeader& h) { h.flags |= history_follows; }));
  EXPECT_FALSE(fits([](FirstHeader& h) { h.flags |= group_follows; }));
  EXPECT_FALSE(fits([](FirstHeader& h) { h.flags |= lengths_follow; }));
  EXPECT_FALSE(fits([](FirstHeader& h) { h.label.variant = whole_variants_end; }));
  EXPECT_FALSE(fits([](FirstHeader& h) { h.channel.in_short = false; })) << "the channel has to be named";
  EXPECT_TRUE(fits([](FirstHeader& h) { h.channel.channel = UINT32_MAX; }));
  EXPECT_FALSE(fits([](FirstHeader& h) { h.channel.sequence_high = 1; }));
  EXPECT_FALSE(fits([](FirstHeader& h) { h.channel.ordinal = 0x1'0000'0000; }));
}

TEST(WholeDatagram, MayHaveNoPayload) {
  std::array<std::byte, first_header_bytes> bytes;
  encode_in_short(whole_header(), bytes.data());
  const auto d = parse(bytes);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->first.total, 0U);
  EXPECT_TRUE(d->payload.empty());
}

TEST(WholeDatagram, IsRefusedWhenItCannotBeTrue) {
  std::vector<std::byte> bytes(datagram_bytes_max + 1);
  FirstHeader header = whole_header();
  for (const std::uint64_t mask : {std::uint64_t{5}, header.mask}) {
    header.mask = mask;
    encode_in_short(header, bytes.data());
    for (std::size_t n = 0; n < header.bytes_in_short(); ++n)
      EXPECT_FALSE(parse(std::span(bytes).first(n))) << n;
  }
  EXPECT_TRUE(parse(std::span(bytes).first(datagram_bytes_max)));
  EXPECT_FALSE(parse(bytes)) << "longer than UDP allows";
  header.channel.ordinal = 0;
  encode_in_short(header, bytes.data());
  EXPECT_FALSE(parse(std::span(bytes).first(first_header_bytes))) << "ordinals count from 1";
}
}  // namespace
}  // namespace sft::udp
