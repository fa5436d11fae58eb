// Against an independent implementation: Cyclone DDS's serializer, and stock idlc for the same IDL files.
#include <gtest/gtest.h>
#include <nav_msgs/msg/OccupancyGrid.h>
#include <nav_msgs/msg/Odometry.h>
#include <proof.h>
#include <sensor_msgs/msg/BatteryState.h>
#include <sensor_msgs/msg/Image.h>
#include <sensor_msgs/msg/LaserScan.h>
#include <sensor_msgs/msg/PointCloud2.h>

#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <nav_msgs/msg/Odometry.hpp>
#include <ostream>
#include <proof.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/typesupport/decode.h"
#include "tests/support/c_struct.h"
#include "tests/support/cyclone_cdr.h"
#include "tests/support/cyclone_loopback.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"

namespace sft {
namespace {

using test::CStruct;
using test::Encoded;
using test::MessageType;
using test::OwnedValue;

/// One type as both implementations know it.
struct Contestant {
  MessageType ours;
  const dds_topic_descriptor_t* theirs;
  int rounds = 1000;
};

void PrintTo(const Contestant& type, std::ostream* out) { *out << type.theirs->m_typename; }

std::vector<Contestant> contestants() {
  return {{test::message_type<sensor_msgs::msg::PointCloud2>(), &sensor_msgs_msg_PointCloud2_desc, 2000},
          {test::message_type<sensor_msgs::msg::LaserScan>(), &sensor_msgs_msg_LaserScan_desc, 2000},
          {test::message_type<sensor_msgs::msg::BatteryState>(), &sensor_msgs_msg_BatteryState_desc, 2000},
          {test::message_type<sensor_msgs::msg::Image>(), &sensor_msgs_msg_Image_desc, 2000},
          {test::message_type<nav_msgs::msg::OccupancyGrid>(), &nav_msgs_msg_OccupancyGrid_desc, 2000},
          {test::message_type<nav_msgs::msg::Odometry>(), &nav_msgs_msg_Odometry_desc, 2000},
          {test::message_type<proof::Misaligned>(), &proof_Misaligned_desc},
          {test::message_type<proof::Scene>(), &proof_Scene_desc},
          {test::message_type<proof::Bounded>(), &proof_Bounded_desc},
          {test::message_type<proof::Keyed>(), &proof_Keyed_desc},
          {test::message_type<proof::Wide>(), &proof_Wide_desc},
          {test::message_type<proof::Chunks>(), &proof_Chunks_desc}};
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
    std::vector<std::uint32_t> index(ours().support->slots());
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
  int rounds() const { return GetParam().rounds; }

  test::RandomValues values{random};

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
  for (int round = 0; round < rounds(); ++round) {
    const OwnedValue value = random_value();
    ASSERT_EQ(our_bytes(value), their_bytes(value)) << "in round " << round;
  }
}

TEST_P(Differential, CycloneDecodesWhatWeEncode) {
  test::CycloneReader reader(theirs());
  for (int round = 0; round < rounds(); ++round) {
    const OwnedValue value = random_value();
    const void* c_struct = reader.deserialize(our_bytes(value));
    ASSERT_NE(c_struct, nullptr) << "in round " << round;
    ASSERT_TRUE(same_value(test::from_c_struct(c_struct, ours().make()), value)) << "in round " << round;
  }
}

TEST_P(Differential, WeDecodeWhatCycloneEncodes) {
  for (int round = 0; round < rounds(); ++round) {
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

// We are stricter in one thing, a NUL within a string, and more lenient in two that real payloads have:
// strings of length 0 (not even a NUL), and bytes left over. Both show when the value is encoded again.
TEST_P(Differential, OfDamagedBodiesBothAcceptTheSameAndReadTheSame) {
  test::CycloneReader reader(theirs());
  for (int round = 0; round < rounds(); ++round) {
    const std::vector<std::byte> body = damaged(our_bytes(random_value()));
    const void* c_struct = reader.deserialize(body);
    const WalkStatus status = walked_by_us(body);
    if (c_struct != nullptr && status == WalkStatus::ok) {
      ASSERT_TRUE(same_value(decoded_by_us(body), test::from_c_struct(c_struct, ours().make())));
    } else if (c_struct != nullptr) {
      ASSERT_EQ(status, WalkStatus::bad_string);
    } else if (status == WalkStatus::ok) {
      ASSERT_NE(our_bytes(decoded_by_us(body)), body);
    }
  }
}

// The same through writers and readers of a domain: what is said above of the serializer is what goes over
// the wire, behind the encapsulation that we imply.
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

const auto contestant_name = [](const auto& type) { return type.param.ours.short_name(); };

INSTANTIATE_TEST_SUITE_P(Of, Differential, ::testing::ValuesIn(contestants()), contestant_name);

/// A type, a mask of it, and as what Cyclone knows the projected type.
struct ProjectedType {
  MessageType whole;
  std::string mask;
  const dds_topic_descriptor_t* projected;
};

void PrintTo(const ProjectedType& type, std::ostream* out) { *out << type.projected->m_typename; }

class DifferentialProjection : public test::RandomTest,
                               public ::testing::WithParamInterface<ProjectedType> {};

// Cyclone reads our masked payload as the type that has only those members, and writes the same bytes.
TEST_P(DifferentialProjection, AMaskedPayloadIsTheCdrOfTheProjectedType) {
  const auto& [whole, mask, projected] = GetParam();
  const FieldMask closed = whole.support->closed(whole.support->parse_mask(mask).value());
  test::RandomValues values(random);
  test::CycloneReader reader(*projected);
  for (int round = 0; round < 1000; ++round) {
    OwnedValue value = whole.make();
    values.fill(value.type(), value.get());
    const std::vector<std::byte> masked = Encoded(value.type(), value.get(), closed).bytes();
    const void* c_struct = reader.deserialize(masked);
    ASSERT_NE(c_struct, nullptr) << "in round " << round;
    ASSERT_EQ(test::cyclone_serialize(*projected, c_struct), masked) << "in round " << round;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Of, DifferentialProjection,
    ::testing::Values(ProjectedType{test::message_type<sensor_msgs::msg::PointCloud2>(), "height, width",
                                    &proof_projected_CloudSize_desc},
                      ProjectedType{
                          test::message_type<sensor_msgs::msg::PointCloud2>(),
                          "header, width, fields, is_bigendian, point_step, row_step, data, is_dense",
                          &proof_projected_CloudWithoutHeight_desc},
                      ProjectedType{test::message_type<sensor_msgs::msg::PointCloud2>(),
                                    "header.frame_id, fields[].name, fields[].count, is_dense",
                                    &proof_projected_CloudNames_desc},
                      ProjectedType{test::message_type<proof::Misaligned>(), "pairs[].b, grid[].b, last",
                                    &proof_projected_MisalignedB_desc},
                      ProjectedType{test::message_type<proof::Scene>(),
                                    "tracks[].kind, tracks[].pairs[].b, tracks[].mark, tail",
                                    &proof_projected_SceneWithoutA_desc}),
    [](const auto& type) {
      const std::string name = type.param.projected->m_typename;
      return name.substr(name.rfind(':') + 1);
    });

}  // namespace
}  // namespace sft
