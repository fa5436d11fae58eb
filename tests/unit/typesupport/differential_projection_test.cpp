// Cyclone DDS's serializer reads masked payloads as values of the projected types in proof.idl.
#include <gtest/gtest.h>
#include <proof.h>

#include <ostream>
#include <proof.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "tests/support/cyclone_cdr.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"

namespace sft {
namespace {

using test::Encoded;
using test::MessageType;
using test::OwnedValue;

/// A type, a mask of the type, and the projected type in Cyclone's description.
struct ProjectedType {
  MessageType whole;
  std::string mask;
  const dds_topic_descriptor_t* projected;
};

void PrintTo(const ProjectedType& type, std::ostream* out) { *out << type.projected->m_typename; }

class DifferentialProjection : public test::RandomTest,
                               public ::testing::WithParamInterface<ProjectedType> {};

// Cyclone reads the masked payload as the type with only the members in the mask, and writes the same bytes
// again.
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
