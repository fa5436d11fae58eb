// Comparison with Cyclone DDS's serializer, which uses C types that stock idlc makes of the same IDL.
#include <gtest/gtest.h>

#include <algorithm>

#include "sft/detail/decode.h"
#include "tests/support/c_struct.h"
#include "tests/support/contestant.h"
#include "tests/support/cyclone_cdr.h"
#include "tests/support/cyclone_loopback.h"
#include "tests/support/encoded.h"
#include "tests/support/random_value.h"
#include "tests/support/reference.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 1000
#endif

namespace sft {
namespace {

using namespace detail;

using test::Contestant;
using test::CStruct;
using test::Encoded;
using test::MessageType;
using test::OwnedValue;

constexpr int rounds = SFT_TEST_ROUNDS;

bool has_enumerations(const StructType& type) {
  return std::ranges::any_of(type.members, [](const Member& m) {
    return m.enumeration != nullptr || (m.kind == Kind::structure && has_enumerations(*m.type));
  });
}

class Differential : public test::RandomTest, public ::testing::WithParamInterface<Contestant> {
 protected:
  OwnedValue random_value() {
    OwnedValue value = ours().make();
    values.fill(value.type(), value.get());
    return value;
  }

  std::vector<std::byte> our_bytes(const OwnedValue& value) const {
    return Encoded(value.type(), value.get(), ours().support->full()).bytes();
  }
  std::vector<std::byte> their_bytes(const OwnedValue& value) const {
    return test::cyclone_serialize(theirs(), CStruct(value).get());
  }

  WalkStatus walked_by_us(const std::vector<std::byte>& body) const {
    std::vector<std::uint32_t> index(ours().support->index_slots());
    return build_index(state_of(body), ours().type(), index);
  }

  OwnedValue decoded_by_us(const std::vector<std::byte>& body) const {
    OwnedValue value = ours().make();
    EXPECT_EQ(walked_by_us(body), WalkStatus::ok);
    EXPECT_EQ(decode(state_of(body), value.type(), value.get()), WalkStatus::ok);
    return value;
  }

  std::vector<std::byte> damaged(std::vector<std::byte> body) {
    for (int i = 0; i < 3; ++i) {
      std::byte& byte = body[values.up_to(body.size() - 1)];
      byte = values.up_to(1) == 0 ? static_cast<std::byte>(random()) : static_cast<std::byte>(random() % 8);
    }
    return body;
  }

  const MessageType& ours() const { return GetParam().ours; }
  const dds_topic_descriptor_t& theirs() const { return *GetParam().theirs; }

  test::RandomValues values{random, test::Enumerated::declared};

 private:
  SampleState state_of(const std::vector<std::byte>& body) const {
    return {body.data(), static_cast<std::uint32_t>(body.size()), nullptr, &mask_};
  }

  FieldMask mask_ = ours().support->full();
};

TEST_P(Differential, TheCStructIsLaidOutAsTheGenericConversionAssumes) {
  EXPECT_EQ(theirs().m_typename, ours().support->name());
  EXPECT_EQ(theirs().m_size, test::c_layout(ours().type()).size);
  EXPECT_EQ(theirs().m_align, test::c_layout(ours().type()).alignment);
  const OwnedValue value = random_value();
  EXPECT_TRUE(same_value(test::from_c_struct(CStruct(value).get(), ours().make()), value));
}

TEST_P(Differential, CycloneWritesTheTypeInPlainCdr) {
  EXPECT_TRUE(test::cyclone_writes_plain_cdr(theirs()));
}

TEST_P(Differential, OurBytesAreCyclones) {
  for (int round = 0; round < rounds; ++round) {
    const OwnedValue value = random_value();
    ASSERT_EQ(our_bytes(value), their_bytes(value)) << "in round " << round;
  }
}

TEST_P(Differential, CycloneDecodesWhatWeEncode) {
  test::CycloneReader reader(theirs());
  for (int round = 0; round < rounds; ++round) {
    const OwnedValue value = random_value();
    const void* c_struct = reader.deserialize(our_bytes(value));
    ASSERT_NE(c_struct, nullptr) << "in round " << round;
    ASSERT_TRUE(same_value(test::from_c_struct(c_struct, ours().make()), value)) << "in round " << round;
  }
}

TEST_P(Differential, WeDecodeWhatCycloneEncodes) {
  for (int round = 0; round < rounds; ++round) {
    const OwnedValue value = random_value();
    ASSERT_TRUE(same_value(decoded_by_us(their_bytes(value)), value)) << "in round " << round;
  }
}

TEST_P(Differential, BothRefuseTruncatedBodies) {
  test::CycloneReader reader(theirs());
  for (int round = 0; round < 200; ++round) {
    std::vector<std::byte> body = our_bytes(random_value());
    body.resize(values.up_to(body.size() - 1));
    ASSERT_EQ(reader.deserialize(body), nullptr);
    ASSERT_EQ(walked_by_us(body), WalkStatus::truncated);
  }
}

// SFT is stricter in one point: it refuses a NUL within a string. SFT is more lenient in other points. It
// accepts strings of length 0 (without a NUL) and trailing bytes, because real payloads have them; the
// encoded value then differs from these bytes. SFT also accepts unknown values of enumerations and bitmasks.
TEST_P(Differential, OfDamagedBodiesBothAcceptTheSameAndReadTheSame) {
  test::CycloneReader reader(theirs());
  for (int round = 0; round < rounds; ++round) {
    const std::vector<std::byte> body = damaged(our_bytes(random_value()));
    const void* c_struct = reader.deserialize(body);
    const WalkStatus status = walked_by_us(body);
    if (c_struct != nullptr && status == WalkStatus::ok) {
      ASSERT_TRUE(same_value(decoded_by_us(body), test::from_c_struct(c_struct, ours().make())));
    } else if (c_struct != nullptr) {
      ASSERT_EQ(status, WalkStatus::bad_string);
    } else if (status == WalkStatus::ok && !has_enumerations(ours().type())) {
      ASSERT_NE(our_bytes(decoded_by_us(body)), body);
    }
  }
}

// Repeats the comparison with writers and readers of a domain. So the results for the serializer also hold
// on the wire, where the encapsulation that SFT assumes precedes the body.
TEST_P(Differential, WhatACycloneWriterSendsIsOurEncapsulationAndOurBytes) {
  test::CycloneLoopback loopback(theirs());
  if (!loopback.ok()) GTEST_SKIP() << "no DDS participant on the loopback interface: " << loopback.error();
  for (int round = 0; round < 20; ++round) {
    const OwnedValue value = random_value();
    const test::CyclonePayload payload = loopback.sent(CStruct(value).get());
    ASSERT_EQ(payload.encapsulation, encapsulation_cdr_le) << "in round " << round;
    ASSERT_EQ(payload.body, our_bytes(value)) << "in round " << round;
  }
}

TEST_P(Differential, ACycloneReaderTakesOurPayload) {
  test::CycloneLoopback loopback(theirs());
  if (!loopback.ok()) GTEST_SKIP() << "no DDS participant on the loopback interface: " << loopback.error();
  for (int round = 0; round < 20; ++round) {
    const OwnedValue value = random_value();
    OwnedValue received = ours().make();
    ASSERT_TRUE(loopback.receive(our_bytes(value),
                                 [&](const void* c) { received = test::from_c_struct(c, received); }));
    ASSERT_TRUE(same_value(received, value)) << "in round " << round;
  }
}

/// Tests all types, including those that Cyclone does not know, with random integers in enumerations.
class RoundTrip : public Differential {};

TEST_P(RoundTrip, ThroughTheBytesOfThePlainestEncoderGivesTheSameValue) {
  test::RandomValues any(random);
  for (int round = 0; round < rounds; ++round) {
    OwnedValue value = ours().make();
    any.fill(value.type(), value.get());
    const std::vector<std::byte> bytes = our_bytes(value);
    ASSERT_EQ(bytes, test::reference::cdr(value, ours().support->full())) << "in round " << round;
    ASSERT_TRUE(same_value(decoded_by_us(bytes), value)) << "in round " << round;
  }
}

std::vector<Contestant> known_to_both() {
  std::vector<Contestant> types = test::contestants();
  std::erase_if(types, [](const Contestant& type) { return type.theirs == nullptr; });
  return types;
}

const auto contestant_name = [](const auto& type) { return type.param.ours.test_name(); };

INSTANTIATE_TEST_SUITE_P(Of, Differential, ::testing::ValuesIn(known_to_both()), contestant_name);
INSTANTIATE_TEST_SUITE_P(Of, RoundTrip, ::testing::ValuesIn(test::contestants()), contestant_name);

}  // namespace
}  // namespace sft
