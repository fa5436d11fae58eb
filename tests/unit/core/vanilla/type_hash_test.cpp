// The hashes of types equal those that nodes of ROS 2 announce. The expected values are published: in keys of
// rmw_zenoh and zenoh-plugin-ros2dds, and in recordings.
#include "core/vanilla/type_hash.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "sft/detail/type_table.h"
#include "sft/msg_text.h"

namespace sft::core {
namespace {

std::optional<std::string> hash_of(const Result<DynamicType>& type) {
  EXPECT_TRUE(type) << type.error().message;
  return type ? ros_type_hash(type->support().type()) : std::nullopt;
}

std::optional<std::string> hash_of(const std::string& name) {
  const std::filesystem::path roots[] = {SFT_INTERFACES};
  return hash_of(find_msg(name, roots));
}

TEST(TypeHash, IsTheOnePublishedForEachMessage) {
  EXPECT_EQ(hash_of("std_msgs/msg/String"),
            "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18");
  EXPECT_EQ(hash_of("sensor_msgs/msg/PointCloud2"),
            "RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5");
  EXPECT_EQ(hash_of("geometry_msgs/msg/TwistStamped"),
            "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64");
  EXPECT_EQ(hash_of("sensor_msgs/msg/Imu"),
            "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b");
  EXPECT_EQ(hash_of("nav_msgs/msg/Odometry"),
            "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0");
  EXPECT_EQ(hash_of("rcl_interfaces/msg/Log"),
            "RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac");
}

TEST(TypeHash, CountsBoundsAndConstantsAsRosDoes) {
  const auto entities = from_msg("rmw_dds_common/msg/ParticipantEntitiesInfo",
                                 "Gid gid\n"
                                 "NodeEntitiesInfo[] node_entities_info_seq\n"
                                 "================\n"
                                 "MSG: rmw_dds_common/Gid\n"
                                 "uint8[16] data\n"
                                 "================\n"
                                 "MSG: rmw_dds_common/NodeEntitiesInfo\n"
                                 "string<=256 node_namespace\n"
                                 "string<=256 node_name\n"
                                 "Gid[] reader_gid_seq\n"
                                 "Gid[] writer_gid_seq\n");
  EXPECT_EQ(hash_of(entities), "RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e");
}

TEST(TypeHash, OfACharIsThatOfAUint8) {
  EXPECT_EQ(hash_of(from_msg("a/msg/B", "char c")), hash_of(from_msg("a/msg/B", "uint8 c")));
  EXPECT_NE(hash_of(from_msg("a/msg/B", "byte c")), hash_of(from_msg("a/msg/B", "uint8 c")));
}

TEST(TypeHash, LeavesOutConstantsAndDefaults) {
  EXPECT_EQ(hash_of(from_msg("a/msg/B", "int32 X=5\nint32 c 3\n")),
            hash_of(from_msg("a/msg/B", "int32 c\n")));
}

TEST(TypeHash, DiffersWithEachNameKindAndBound) {
  const auto plain = hash_of(from_msg("a/msg/B", "int32[] c"));
  for (const char* other : {"int32[] d", "int32[<=3] c", "int32[3] c", "int32 c", "uint32[] c"})
    EXPECT_NE(hash_of(from_msg("a/msg/B", other)), plain) << other;
}

TEST(TypeHash, IsMissingForTypesThatRosCannotDescribeAlsoWhereTheyAreNested) {
  using Member = StructType::Member;
  const Member plain[] = {{.name = "a", .kind = Member::Kind::int32}};
  const Member key[] = {{.name = "a", .kind = Member::Kind::int32, .key = true}};
  EXPECT_TRUE(ros_type_hash(StructType("a::msg::B", plain)));
  const StructType keyed("a::msg::K", key);
  EXPECT_FALSE(ros_type_hash(keyed));
  const Member nested[] = {{.name = "k", .kind = Member::Kind::structure, .type = &keyed}};
  EXPECT_FALSE(ros_type_hash(StructType("a::msg::C", nested)));
  constexpr EnumType::Enumerator red[] = {{"red", 0}};
  const EnumType colour{"a::msg::Colour", false, red};
  const Member enumeration[] = {{.name = "e", .kind = Member::Kind::uint32, .enumeration = &colour}};
  EXPECT_FALSE(ros_type_hash(StructType("a::msg::E", enumeration)));
}

}  // namespace
}  // namespace sft::core
