// The hashes of types equal those that nodes of ROS 2 announce. The expected values are published: in keys of
// rmw_zenoh and zenoh-plugin-ros2dds, in recordings, and in code that others have generated from the
// messages.
#include "core/vanilla/type_hash.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>

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
  EXPECT_EQ(hash_of("sensor_msgs/msg/CameraInfo"),
            "RIHS01_b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275");
}

TEST(TypeHash, IsTheOnePublishedForEachKindOfNumber) {
  const std::pair<const char*, const char*> published[] = {
      {"Bool", "feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9"},
      {"Byte", "41e1a3345f73fe93ede006da826a6ee274af23dd4653976ff249b0f44e3e798f"},
      {"Char", "3ad2d04dd29ba19d04b16659afa3ccaedd691914b02a64e82e252f2fa6a586a9"},
      {"Float32", "7170d3d8f841f7be3172ce5f4f59f3a4d7f63b0447e8b33327601ad64d83d6e2"},
      {"Float64", "705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a"},
      {"Int8", "26525065a403d972cb672f0777e333f0c799ad444ae5fcd79e43d1e73bd0f440"},
      {"Int16", "1dcc3464e47c288a55f943a389d337cdb06804de3f5cd7a266b0de718eee17e5"},
      {"Int32", "b6578ded3c58c626cfe8d1a6fb6e04f706f97e9f03d2727c9ff4e74b1cef0deb"},
      {"Int64", "8cd1048c2f186b6bd9a92472dc1ce51723c0833a221e2b7aecfff111774f4b49"},
      {"UInt8", "6138bd83d8c3569cb80a667db03cfc1629f529fee79d944c39c34e352e72f010"},
      {"UInt16", "08a406e4b022bc22e907f985d6a9e9dd1d4fbecae573549cf49350113e7757b1"},
      {"UInt32", "a5c874829b752bc5fa190024b0ad76f578cc278271e855c7d02a818b3516fb4a"},
      {"UInt64", "fbdc52018fc13755dce18024d1a671c856aa8b4aaf63adfb095b608f98e8c943"},
      {"ByteMultiArray", "972fec7f50ab3c1d06783c228e79e8a9a509021708c511c059926261ada901d4"},
      {"Empty", "20b625256f32d5dbc0d04fee44f43c41e51c70d3502f84b4a08e7a9c26a96312"}};
  for (const auto& [name, hash] : published)
    EXPECT_EQ(hash_of("std_msgs/msg/" + std::string(name)), "RIHS01_" + std::string(hash)) << name;
}

TEST(TypeHash, IsTheOnePublishedForTypesThatNestOthersOfTheirPackage) {
  const auto event = from_msg("rcl_interfaces/msg/ParameterEvent",
                              "builtin_interfaces/Time stamp\n"
                              "string node\n"
                              "Parameter[] new_parameters\n"
                              "Parameter[] changed_parameters\n"
                              "Parameter[] deleted_parameters\n"
                              "================\n"
                              "MSG: builtin_interfaces/Time\n"
                              "int32 sec\n"
                              "uint32 nanosec\n"
                              "================\n"
                              "MSG: rcl_interfaces/Parameter\n"
                              "string name\n"
                              "ParameterValue value\n"
                              "================\n"
                              "MSG: rcl_interfaces/ParameterValue\n"
                              "uint8 type\n"
                              "bool bool_value\n"
                              "int64 integer_value\n"
                              "float64 double_value\n"
                              "string string_value\n"
                              "byte[] byte_array_value\n"
                              "bool[] bool_array_value\n"
                              "int64[] integer_array_value\n"
                              "float64[] double_array_value\n"
                              "string[] string_array_value\n");
  EXPECT_EQ(hash_of(event), "RIHS01_043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204");
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
