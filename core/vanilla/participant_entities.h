// The message rmw_dds_common/msg/ParticipantEntitiesInfo. With this message, which is sent on the topic
// "ros_discovery_info", each process of ROS 2 announces its nodes, and the readers and writers of its
// participant that belong to each node. Pure functions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sft::core {

/// A GUID in the order of the bytes on the wire: 12 bytes that are the same for all entities of a
/// participant, and 4 bytes that identify the entity.
using Guid = std::array<std::uint8_t, 16>;

/// The number of bytes that a GUID has in the message. A node that reads a message with GUIDs of 16 bytes as
/// one with 24 may try to allocate gigabytes, and end.
enum class GuidBytes : std::uint8_t {
  as_of_iron = 16,
  before_iron = 24,  ///< from Foxy to Humble; the last 8 bytes are 0
};

/// Returns the size for a distribution of ROS 2 (the value of ROS_DISTRO), or nothing if the distribution
/// is unknown.
std::optional<GuidBytes> guid_bytes_of(std::string_view distribution);

struct ParticipantEntities {
  struct Node {
    std::string name_space;  ///< begins with a slash; may consist of the slash only
    std::string name;
    std::vector<Guid> readers{}, writers{};
  };
  Guid participant{};
  std::vector<Node> nodes{};
};

/// Returns the body of the message as little-endian CDR.
std::vector<std::byte> encode_entities(const ParticipantEntities& entities, GuidBytes guid_bytes);

struct ReceivedEntities {
  ParticipantEntities entities;
  GuidBytes guid_bytes{};
};
/// Reads such a body, and determines the size of its GUIDs. The end of the body may be padded. The result is
/// empty if the body fits neither size, or both.
std::optional<ReceivedEntities> decode_entities(std::span<const std::byte> body);

}  // namespace sft::core
