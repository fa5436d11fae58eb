// Readers and writers of ROS 2 get the names of their nodes. Forged messages about nodes use a limited
// amount of memory.
#include "core/vanilla/ros_nodes.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

constexpr std::uint64_t one_handle = 7, other_handle = 8;

/// The GUID of an entity of a participant. The entity with the number 0 is the participant itself.
Guid guid(std::uint16_t participant, std::uint32_t entity = 0) {
  Guid guid{};
  guid[0] = static_cast<std::uint8_t>(participant >> 8);
  guid[11] = static_cast<std::uint8_t>(participant);
  for (int i = 0; i < 4; ++i)
    guid[static_cast<std::size_t>(15 - i)] = static_cast<std::uint8_t>(entity >> 8 * i);
  return guid;
}

using Node = ParticipantEntities::Node;

ReceivedEntities message(std::uint16_t participant, std::vector<Node> nodes,
                         GuidBytes size = GuidBytes::as_of_iron) {
  return {.entities = {.participant = guid(participant), .nodes = std::move(nodes)}, .guid_bytes = size};
}

TEST(RosNodes, AreFoundByTheirReadersAndWriters) {
  RosNodes nodes;
  EXPECT_TRUE(nodes.note(
      one_handle, guid(1),
      message(1, {{.name_space = "/", .name = "talker", .writers = {guid(1, 3)}},
                  {.name_space = "/left/arm", .name = "listener", .readers = {guid(1, 9), guid(1, 4)}}})));
  EXPECT_EQ(nodes.node_of(guid(1, 3)), "/talker");
  EXPECT_EQ(nodes.node_of(guid(1, 4)), "/left/arm/listener");
  EXPECT_EQ(nodes.node_of(guid(1, 9)), "/left/arm/listener");
  EXPECT_EQ(nodes.node_of(guid(1, 5)), "");
  EXPECT_EQ(nodes.node_of(guid(2, 3)), "");
}

TEST(RosNodes, AreThoseOfTheLastMessageOfEachParticipant) {
  RosNodes nodes;
  const ReceivedEntities first = message(1, {{.name_space = "/", .name = "a", .writers = {guid(1, 3)}}});
  EXPECT_TRUE(nodes.note(one_handle, guid(1), first));
  EXPECT_FALSE(nodes.note(one_handle, guid(1), first)) << "nothing new";
  EXPECT_TRUE(nodes.note(other_handle, guid(2),
                         message(2, {{.name_space = "/", .name = "b", .writers = {guid(2, 3)}}})));
  EXPECT_TRUE(nodes.note(one_handle, guid(1), message(1, {})));
  EXPECT_EQ(nodes.node_of(guid(1, 3)), "");
  EXPECT_EQ(nodes.node_of(guid(2, 3)), "/b");
  EXPECT_TRUE(nodes.forget(other_handle));
  EXPECT_FALSE(nodes.forget(other_handle));
  EXPECT_EQ(nodes.node_of(guid(2, 3)), "");
}

TEST(RosNodes, TheSizesInUseAreThoseOfParticipantsThatAreThere) {
  RosNodes nodes;
  EXPECT_FALSE(nodes.uses(GuidBytes::as_of_iron));
  nodes.note(one_handle, guid(1), message(1, {}));
  nodes.note(other_handle, guid(2), message(2, {}, GuidBytes::before_iron));
  EXPECT_TRUE(nodes.uses(GuidBytes::as_of_iron));
  EXPECT_TRUE(nodes.uses(GuidBytes::before_iron));
  nodes.forget(one_handle);
  EXPECT_FALSE(nodes.uses(GuidBytes::as_of_iron));
}

TEST(RosNodes, NobodyNamesTheEndpointsOfOthers) {
  RosNodes nodes;
  EXPECT_FALSE(nodes.note(one_handle, guid(1), message(2, {}))) << "it comes from another participant";
  nodes.note(one_handle, guid(1),
             message(1, {{.name_space = "/", .name = "forger", .readers = {guid(2, 3)}}}));
  EXPECT_EQ(nodes.node_of(guid(2, 3)), "");
}

TEST(RosNodes, WithNamesThatRosDoesNotAllowAreNone) {
  RosNodes nodes;
  nodes.note(one_handle, guid(1),
             message(1, {{.name_space = "/", .name = "\x1b[2J", .readers = {guid(1, 1)}},
                         {.name_space = "/a\nb", .name = "c", .readers = {guid(1, 2)}},
                         {.name_space = "/", .name = "", .readers = {guid(1, 3)}},
                         {.name_space = "/", .name = "_ros2cli_daemon_0", .readers = {guid(1, 4)}}}));
  for (std::uint32_t i = 1; i <= 3; ++i) EXPECT_EQ(nodes.node_of(guid(1, i)), "") << i;
  EXPECT_EQ(nodes.node_of(guid(1, 4)), "/_ros2cli_daemon_0");
}

TEST(RosNodes, OfFurtherParticipantsAreIgnored) {
  RosNodes nodes;
  const auto note = [&](std::uint16_t participant) {
    return nodes.note(
        participant, guid(participant),
        message(participant, {{.name_space = "/", .name = "a", .readers = {guid(participant, 1)}}}));
  };
  for (std::uint16_t i = 0; i < RosNodes::participants_max; ++i) EXPECT_TRUE(note(i));
  EXPECT_FALSE(note(RosNodes::participants_max));
  EXPECT_EQ(nodes.node_of(guid(RosNodes::participants_max, 1)), "");
  EXPECT_TRUE(nodes.forget(0));
  EXPECT_TRUE(note(RosNodes::participants_max));
}

TEST(RosNodes, BeyondTheLimitOfMemoryHaveNoNamesButASize) {
  RosNodes nodes;
  const auto note = [&](std::uint16_t participant) {
    std::vector<Guid> many;
    for (std::uint32_t i = 0; i < RosNodes::bytes_max / 12; ++i) many.push_back(guid(participant, i));
    return nodes.note(participant, guid(participant),
                      message(participant, {{.name_space = "/", .name = "a", .writers = std::move(many)}}));
  };
  EXPECT_TRUE(note(1));
  EXPECT_TRUE(note(2));
  EXPECT_EQ(nodes.node_of(guid(1, 5)), "/a");
  EXPECT_EQ(nodes.node_of(guid(2, 5)), "");
  nodes.forget(1);
  EXPECT_TRUE(nodes.uses(GuidBytes::as_of_iron)) << "that of the second one";
  EXPECT_TRUE(note(2));
  EXPECT_EQ(nodes.node_of(guid(2, 5)), "/a") << "there is room again";
}

}  // namespace
}  // namespace sft::core
