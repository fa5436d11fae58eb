// Converts the encodings that Cyclone DDS's serializer writes, in both versions of CDR and both byte orders.
#include <foreign.h>
#include <gtest/gtest.h>
#include <nav_msgs/msg/OccupancyGrid.h>
#include <nav_msgs/msg/Odometry.h>
#include <proof.h>
#include <sensor_msgs/msg/BatteryState.h>
#include <sensor_msgs/msg/Image.h>
#include <sensor_msgs/msg/LaserScan.h>
#include <sensor_msgs/msg/PointCloud2.h>

#include <foreign.hpp>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <nav_msgs/msg/Odometry.hpp>
#include <ostream>
#include <proof.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/convert.h"
#include "tests/support/c_struct.h"
#include "tests/support/cyclone_cdr.h"
#include "tests/support/encoded.h"
#include "tests/support/foreign_cdr.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 1000
#endif

namespace sft {
namespace {

using namespace detail;

constexpr int rounds = SFT_TEST_ROUNDS;  // rounds per type and encoding

using test::CStruct;
using test::ForeignEncoding;
using test::MessageType;
using test::OwnedValue;

/// A type, described for both implementations.
struct Contestant {
  MessageType ours;
  const dds_topic_descriptor_t* theirs;
};

void PrintTo(const Contestant& type, std::ostream* out) { *out << type.theirs->m_typename; }

std::vector<Contestant> contestants() {
  return {{test::message_type<sensor_msgs::msg::PointCloud2>(), &sensor_msgs_msg_PointCloud2_desc},
          {test::message_type<sensor_msgs::msg::LaserScan>(), &sensor_msgs_msg_LaserScan_desc},
          {test::message_type<sensor_msgs::msg::BatteryState>(), &sensor_msgs_msg_BatteryState_desc},
          {test::message_type<sensor_msgs::msg::Image>(), &sensor_msgs_msg_Image_desc},
          {test::message_type<nav_msgs::msg::OccupancyGrid>(), &nav_msgs_msg_OccupancyGrid_desc},
          {test::message_type<nav_msgs::msg::Odometry>(), &nav_msgs_msg_Odometry_desc},
          {test::message_type<proof::Misaligned>(), &proof_Misaligned_desc},
          {test::message_type<proof::Scene>(), &proof_Scene_desc},
          {test::message_type<proof::Bounded>(), &proof_Bounded_desc},
          {test::message_type<proof::Keyed>(), &proof_Keyed_desc},
          {test::message_type<proof::Wide>(), &proof_Wide_desc},
          {test::message_type<proof::Chunks>(), &proof_Chunks_desc},
          {test::message_type<foreign::Mixed>(), &foreign_Mixed_desc}};
}

class ForeignDifferential : public test::RandomTest,
                            public ::testing::WithParamInterface<std::tuple<Contestant, ForeignEncoding>> {
 protected:
  OwnedValue random_value() {
    OwnedValue value = ours().make();
    values.fill(value.type(), value.get());
    return value;
  }
  std::vector<std::byte> their_bytes(const OwnedValue& value) const {
    return test::cyclone_serialize(theirs(), CStruct(value).get(), encoding().is_xcdr2,
                                   encoding().byte_order);
  }

  const MessageType& ours() const { return std::get<0>(GetParam()).ours; }
  const dds_topic_descriptor_t& theirs() const { return *std::get<0>(GetParam()).theirs; }
  const ForeignEncoding& encoding() const { return std::get<1>(GetParam()); }

 private:
  test::RandomValues values{random};
};

TEST_P(ForeignDifferential, WhatCycloneWritesIsWhatTheReferenceWrites) {
  for (int round = 0; round < 100; ++round) {
    const OwnedValue value = random_value();
    ASSERT_EQ(test::foreign_cdr(value, encoding()), their_bytes(value)) << "in round " << round;
  }
}

TEST_P(ForeignDifferential, WhatCycloneWritesIsConvertedToOurBytes) {
  for (int round = 0; round < rounds; ++round) {
    const OwnedValue value = random_value();
    const auto payload = test::foreign_payload(their_bytes(value), encoding());
    const Payload parsed = parse_payload(payload).value();
    const ConvertedSize size = converted_size(parsed, ours().type());
    ASSERT_EQ(size.status, WalkStatus::ok) << "in round " << round;
    std::vector<std::byte> body(size.bytes);
    ASSERT_EQ(convert(parsed, ours().type(), body), WalkStatus::ok) << "in round " << round;
    ASSERT_EQ(body, test::Encoded(value.type(), value.get(), ours().support->full()).bytes())
        << "in round " << round;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, ForeignDifferential,
                         ::testing::Combine(::testing::ValuesIn(contestants()),
                                            ::testing::ValuesIn(test::foreign_encodings().first(4))),
                         [](const auto& of) {
                           return std::get<0>(of.param).ours.short_name() + "_in_" +
                                  std::get<1>(of.param).name;
                         });

/// In C every enumeration is an int, whatever its size in the encoding.
class EnumeratedC {
 public:
  explicit EnumeratedC(const foreign::Enumerated& from) {
    struct_.lead = from.lead;
    struct_.color = static_cast<foreign_Color>(from.color);
    struct_.tiny = static_cast<foreign_Tiny>(from.tiny);
    copy<foreign_Color>(from.colors, struct_.colors);
    struct_.between = from.between;
    copy<foreign_Tiny>(from.tinies, struct_.tinies);
    copy<foreign_Medium>(from.mediums, struct_.mediums);
    refer(from.more_colors, colors_, struct_.more_colors);
    refer(from.more_tinies, tinies_, struct_.more_tinies);
    refer(from.more_mediums, mediums_, struct_.more_mediums);
    struct_.last = from.last;
  }
  EnumeratedC(const EnumeratedC&) = delete;
  EnumeratedC& operator=(const EnumeratedC&) = delete;

  const void* get() const { return &struct_; }

 private:
  template <class To, class From>
  static void copy(const From& from, To* to) {
    for (const auto value : from) *to++ = static_cast<To>(value);
  }
  template <class E, class To, class Sequence>
  static void refer(const std::vector<E>& from, std::vector<To>& copied, Sequence& to) {
    copied.resize(from.size());
    copy(from, copied.data());
    to._length = to._maximum = static_cast<std::uint32_t>(from.size());
    to._buffer = copied.data();
  }

  foreign_Enumerated struct_{};
  std::vector<foreign_Color> colors_;
  std::vector<foreign_Tiny> tinies_;
  std::vector<foreign_Medium> mediums_;
};

class EnumeratedDifferential : public test::RandomTest,
                               public ::testing::WithParamInterface<ForeignEncoding> {
 protected:
  foreign::Enumerated random_value() {
    foreign::Enumerated value{.lead = static_cast<std::uint8_t>(random()),
                              .color = one<foreign::Color>(),
                              .tiny = one<foreign::Tiny>(),
                              .between = static_cast<std::uint8_t>(random()),
                              .last = static_cast<double>(random())};
    fill(value.colors);
    fill(value.tinies);
    fill(value.mediums);
    value.more_colors.resize(random() % 4);
    value.more_tinies.resize(random() % 6);
    value.more_mediums.resize(random() % 4);
    fill(value.more_colors);
    fill(value.more_tinies);
    fill(value.more_mediums);
    return value;
  }

 private:
  template <class E>
  E one() {
    return static_cast<E>(random() % 2);
  }
  template <class Values>
  void fill(Values& values) {
    for (auto& value : values) value = one<std::decay_t<decltype(value)>>();
  }
};

// XCDR2 does not count enumerations as primitives, so their collections have a delimiter.
TEST_P(EnumeratedDifferential, WhatCycloneWritesIsConvertedToOurBytes) {
  constexpr const StructType& type = TypeTable<foreign::Enumerated>::type;
  for (int round = 0; round < rounds; ++round) {
    const foreign::Enumerated value = random_value();
    const auto theirs = test::cyclone_serialize(foreign_Enumerated_desc, EnumeratedC(value).get(),
                                                GetParam().is_xcdr2, GetParam().byte_order);
    const auto payload = test::foreign_payload(theirs, GetParam());
    const Payload parsed = parse_payload(payload).value();
    std::vector<std::byte> body(converted_size(parsed, type).bytes);
    ASSERT_EQ(convert(parsed, type, body), WalkStatus::ok) << "in round " << round;
    ASSERT_EQ(body, test::Encoded(value).bytes()) << "in round " << round;
  }
}

INSTANTIATE_TEST_SUITE_P(In, EnumeratedDifferential, ::testing::ValuesIn(test::foreign_encodings().first(4)),
                         [](const auto& of) { return std::string(of.param.name); });

}  // namespace
}  // namespace sft
