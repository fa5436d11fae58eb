// Payloads of other implementations are converted to the bytes that SFT would have written, or they are
// refused.
#include "sft/detail/convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <foreign.hpp>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/decode.h"
#include "tests/support/encoded.h"
#include "tests/support/foreign_cdr.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"
#include "tests/support/reference.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 200
#endif

namespace sft {
namespace {

using namespace detail;

constexpr int rounds = SFT_TEST_ROUNDS;  // rounds per type and encoding

using test::ForeignEncoding;
using test::MessageType;
using test::OwnedValue;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> result;
  for (const int v : values) result.push_back(static_cast<std::byte>(v));
  return result;
}

struct Converted {
  WalkStatus status = WalkStatus::ok;
  std::vector<std::byte> body{};
};

/// Converts a payload as a publisher does. The payload is in memory of exactly its size, so that a sanitizer
/// notices reads beyond it.
Converted converted(const StructType& type, std::span<const std::byte> payload) {
  const std::unique_ptr<std::byte[]> memory(new std::byte[payload.size()]);
  std::copy(payload.begin(), payload.end(), memory.get());
  const Payload parsed = parse_payload({memory.get(), payload.size()}).value();
  const ConvertedSize size = converted_size(parsed, type);
  if (size.status != WalkStatus::ok) return {size.status};
  std::vector<std::byte> body(size.bytes, std::byte{0xaa});
  if (const WalkStatus status = convert(parsed, type, body); status != WalkStatus::ok) return {status};
  const FieldMask full = FieldMask::full(leaf_count(type));
  const SampleState state{.body = body.data(), .body_bytes = size.bytes, .mask = &full};
  std::vector<std::uint32_t> index(slot_count(type));
  std::uint32_t end = 0;
  const WalkStatus status = build_index(state, type, index, &end);
  body.resize(end);
  return {status, body};
}

const foreign::Small small{
    .a = 1, .b = 0x0203040506070809, .c = {foreign::Color::BLUE}, .d = "hi", .e = 0x0a0b};

// Bytes that were written by hand, following XTypes 1.3, 7.4.3.4.
const std::vector<std::byte> small_cdr2_be =
    bytes({0,    6,    0, 2,                              //
           1,    0,    0, 0,                              // field a
           2,    3,    4, 5, 6,   7,   8, 9,              // field b, aligned to 4
           0,    0,    0, 8, 0,   0,   0, 1, 0, 0, 0, 2,  // the delimiter of field c, and field c
           0,    0,    0, 3, 'h', 'i', 0, 0,              // field d
           0x0a, 0x0b, 0, 0});                            // field e and padding
const std::vector<std::byte> small_cdr2_le = bytes({0,    7,    0, 2,                              //
                                                    1,    0,    0, 0,                              //
                                                    9,    8,    7, 6, 5,   4,   3, 2,              //
                                                    8,    0,    0, 0, 1,   0,   0, 0, 2, 0, 0, 0,  //
                                                    3,    0,    0, 0, 'h', 'i', 0, 0,              //
                                                    0x0b, 0x0a, 0, 0});                            //
const std::vector<std::byte> small_cdr_be = bytes({0,    0,    0, 2,                               //
                                                   1,    0,    0, 0, 0,   0,   0, 0,               // field a
                                                   2,    3,    4, 5, 6,   7,   8, 9,  // field b, aligned to 8
                                                   0,    0,    0, 1, 0,   0,   0, 2,  // field c
                                                   0,    0,    0, 3, 'h', 'i', 0, 0,  // field d
                                                   0x0a, 0x0b, 0, 0});                // field e and padding

TEST(ConvertTest, BytesWrittenByHandBecomeTheBytesThatWeWrite) {
  const std::vector<std::byte> ours = test::Encoded(small).bytes();
  for (const auto& payload : {small_cdr2_be, small_cdr2_le, small_cdr_be}) {
    const Converted result = converted(TypeTable<foreign::Small>::type, payload);
    EXPECT_EQ(result.status, WalkStatus::ok);
    EXPECT_EQ(result.body, ours);
  }
}

std::vector<MessageType> types() {
  std::vector<MessageType> types(test::all_types().begin(), test::all_types().end());
  types.push_back(test::message_type<foreign::Mixed>());
  types.push_back(test::message_type<foreign::Enumerated>());
  return types;
}

class Conversion : public test::RandomTest,
                   public ::testing::WithParamInterface<std::tuple<MessageType, ForeignEncoding>> {
 protected:
  OwnedValue random_value() {
    OwnedValue value = type().make();
    values.fill(value.type(), value.get());
    return value;
  }
  std::vector<std::byte> random_payload() {
    return test::foreign_payload(test::foreign_cdr(random_value(), encoding()), encoding());
  }
  Converted converted(std::span<const std::byte> payload) const {
    return sft::converted(type().type(), payload);
  }

  const MessageType& type() const { return std::get<0>(GetParam()); }
  const ForeignEncoding& encoding() const { return std::get<1>(GetParam()); }

  test::RandomValues values{random};
};

TEST_P(Conversion, GivesTheCdrOfTheValue) {
  for (int round = 0; round < rounds; ++round) {
    const OwnedValue value = random_value();
    const auto payload = test::foreign_payload(test::foreign_cdr(value, encoding()), encoding());
    const Converted result = converted(payload);
    ASSERT_EQ(result.status, WalkStatus::ok) << "in round " << round;
    ASSERT_EQ(result.body, test::reference::cdr(value, type().support->full())) << "in round " << round;
  }
}

TEST_P(Conversion, OfATruncatedPayloadIsRefused) {
  for (int round = 0; round < rounds / 4; ++round) {
    std::vector<std::byte> body = test::foreign_cdr(random_value(), encoding());
    body.resize(values.up_to(body.size() - 1));
    const WalkStatus status = converted(test::foreign_payload(body, encoding())).status;
    ASSERT_EQ(status, WalkStatus::truncated) << to_string(status) << " in round " << round;
  }
}

TEST_P(Conversion, OfADamagedPayloadGivesAValidBodyOrNone) {
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::byte> payload = random_payload();
    for (int i = 0; i < 3 && payload.size() > 4; ++i)
      payload[4 + values.up_to(payload.size() - 5)] = static_cast<std::byte>(random() % 8);
    const Converted result = converted(payload);
    ASSERT_LE(result.body.size(), payload.size() * 3 / 2);
    if (result.status != WalkStatus::ok) continue;
    ASSERT_EQ(converted(test::foreign_payload(result.body, test::cdr_le)).body, result.body);
  }
}

TEST_P(Conversion, WorksAtAnyAddress) {
  const std::vector<std::byte> payload = random_payload();
  const Payload aligned = parse_payload(payload).value();
  std::vector<std::byte> expected(converted_size(aligned, type().type()).bytes);
  ASSERT_EQ(convert(aligned, type().type(), expected), WalkStatus::ok);
  for (std::size_t shift = 1; shift < 8; ++shift) {
    std::vector<std::byte> moved(shift);
    moved.insert(moved.end(), payload.begin(), payload.end());
    const Payload parsed = parse_payload(std::span(moved).subspan(shift)).value();
    std::vector<std::byte> body(converted_size(parsed, type().type()).bytes);
    ASSERT_EQ(convert(parsed, type().type(), body), WalkStatus::ok);
    ASSERT_EQ(body, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, Conversion,
                         ::testing::Combine(::testing::ValuesIn(types()),
                                            ::testing::ValuesIn(test::foreign_encodings())),
                         [](const auto& of) {
                           return std::get<0>(of.param).short_name() + "_from_" + std::get<1>(of.param).name;
                         });

/// The tests run once for each encoding, with the same payload.
class ForeignPayloads : public ::testing::TestWithParam<ForeignEncoding> {
 protected:
  static constexpr const StructType& type = TypeTable<sensor_msgs::msg::PointCloud2>::type;

  std::vector<std::byte> body_of(sensor_msgs::msg::PointCloud2 cloud) const {
    OwnedValue value = OwnedValue::of<sensor_msgs::msg::PointCloud2>();
    *static_cast<sensor_msgs::msg::PointCloud2*>(value.get()) = std::move(cloud);
    return test::foreign_cdr(value, GetParam());
  }
  Converted taken_in(const std::vector<std::byte>& changed) const {
    return converted(type, test::foreign_payload(changed, GetParam()));
  }

  /// The body begins with the stamp (8 bytes) and the frame id, and ends with is_dense.
  const std::vector<std::byte> body = body_of({.header = {.frame_id = "abc"}, .is_dense = true});
};

TEST_P(ForeignPayloads, WithABooleanOtherThan0And1AreRefused) {
  std::vector<std::byte> changed = body;
  changed.back() = std::byte{2};
  EXPECT_EQ(taken_in(changed).status, WalkStatus::bad_boolean);
}

TEST_P(ForeignPayloads, WithAStringThatDoesNotEndInNulAreRefused) {
  std::vector<std::byte> changed = body;
  changed[8 + 4 + 3] = std::byte{'d'};
  EXPECT_EQ(taken_in(changed).status, WalkStatus::bad_string);
}

TEST_P(ForeignPayloads, WithANulWithinAStringAreRefused) {
  std::vector<std::byte> changed = body;
  changed[8 + 4 + 1] = std::byte{0};
  EXPECT_EQ(taken_in(changed).status, WalkStatus::bad_string);
}

TEST_P(ForeignPayloads, WithAStringOfLength0ReadAsEmpty) {
  std::vector<std::byte> changed = body;
  std::fill_n(changed.begin() + 8, 4, std::byte{0});
  changed.erase(changed.begin() + 12, changed.begin() + 16);
  const Converted result = taken_in(changed);
  ASSERT_EQ(result.status, WalkStatus::ok);
  const FieldMask full = FieldMask::full(leaf_count(type));
  const SampleState state{.body = result.body.data(),
                          .body_bytes = static_cast<std::uint32_t>(result.body.size()),
                          .mask = &full};
  sensor_msgs::msg::PointCloud2 cloud{.header = {.frame_id = "not this"}};
  ASSERT_EQ(decode(state, type, &cloud), WalkStatus::ok);
  EXPECT_EQ(cloud.header.frame_id, "");
  EXPECT_TRUE(cloud.is_dense);
}

TEST_P(ForeignPayloads, MayEndWithUpToThreeBytesThatTheyDoNotAnnounce) {
  for (std::size_t extra = 0; extra <= 4; ++extra) {
    std::vector<std::byte> payload = test::foreign_payload(body, GetParam());
    payload.resize(4 + body.size() + extra, std::byte{0xee});
    payload[3] = std::byte{0};
    const Converted result = converted(type, payload);
    EXPECT_EQ(result.status, extra <= 3 ? WalkStatus::ok : WalkStatus::trailing_bytes) << extra;
  }
}

TEST_P(ForeignPayloads, WhosePaddingReachesIntoAMemberAreRefused) {
  std::vector<std::byte> payload = test::foreign_payload(body, GetParam());
  payload.resize(4 + body.size());
  payload[3] = std::byte{1};
  EXPECT_EQ(converted(type, payload).status, WalkStatus::truncated);
}

TEST_P(ForeignPayloads, WhosePaddingIsLongerThanTheyAreRefused) {
  std::vector<std::byte> payload = test::foreign_payload({}, GetParam());
  payload.resize(6);
  payload[3] = std::byte{3};
  EXPECT_FALSE(parse_payload(payload));
}

// A false length must cost neither time nor memory.
TEST_P(ForeignPayloads, WhoseLengthsLeadOutsideAreRefused) {
  for (std::size_t at = 0; at + 4 <= body.size(); at += 4) {
    std::vector<std::byte> changed = body;
    std::fill_n(changed.begin() + static_cast<std::ptrdiff_t>(at), 4, std::byte{0xff});
    const Converted result = taken_in(changed);
    EXPECT_LE(result.body.size(), 2 * body.size());
  }
}

INSTANTIATE_TEST_SUITE_P(In, ForeignPayloads, ::testing::ValuesIn(test::foreign_encodings()),
                         [](const auto& of) { return std::string(of.param.name); });

TEST(ConvertTest, ADelimiterThatIsNotTheLengthOfItsCollectionIsRefused) {
  std::vector<std::byte> payload = small_cdr2_le;
  const std::size_t delimiter = 4 + 12;
  for (const int length : {0, 7, 9, 12, 255}) {
    payload[delimiter] = static_cast<std::byte>(length);
    EXPECT_EQ(converted(TypeTable<foreign::Small>::type, payload).status, WalkStatus::bad_delimiter);
  }
}

TEST(ConvertTest, WhatDoesNotFitIsNotWritten) {
  const Payload payload = parse_payload(small_cdr2_le).value();
  const ConvertedSize size = converted_size(payload, TypeTable<foreign::Small>::type);
  for (std::uint32_t room = 0; room < size.bytes; ++room) {
    std::vector<std::byte> body(room);
    EXPECT_EQ(convert(payload, TypeTable<foreign::Small>::type, body), WalkStatus::too_large);
  }
}

std::string refusal(int high, int low) {
  const auto payload = parse_payload(bytes({high, low, 0, 0, 1, 2, 3, 4}));
  return payload ? "" : payload.error().message;
}

TEST(ConvertTest, AnEncodingThatIsNotPlainIsRefusedByName) {
  EXPECT_THAT(refusal(0, 2), AllOf(HasSubstr("PL_CDR_BE"), HasSubstr("00 02"), HasSubstr("@final")));
  EXPECT_THAT(refusal(0, 3), HasSubstr("PL_CDR_LE"));
  for (const int code : {0x08, 0x14}) {
    EXPECT_THAT(refusal(0, code), HasSubstr(" D_CDR2_BE"));
    EXPECT_THAT(refusal(0, code + 1), HasSubstr(" D_CDR2_LE"));
  }
  for (const int code : {0x0a, 0x12}) {
    EXPECT_THAT(refusal(0, code), HasSubstr(" PL_CDR2_BE"));
    EXPECT_THAT(refusal(0, code + 1), HasSubstr(" PL_CDR2_LE"));
  }
}

TEST(ConvertTest, AnEncodingThatNobodyKnowsIsRefusedByNumber) {
  EXPECT_THAT(refusal(0, 4), HasSubstr("00 04"));
  EXPECT_THAT(refusal(0xc0, 1), HasSubstr("c0 01"));
}

TEST(ConvertTest, APayloadWithoutAnEncapsulationIsRefused) {
  EXPECT_FALSE(parse_payload({}));
  EXPECT_FALSE(parse_payload(bytes({0, 1, 0})));
  EXPECT_TRUE(parse_payload(bytes({0, 1, 0, 0})));
}

}  // namespace
}  // namespace sft
