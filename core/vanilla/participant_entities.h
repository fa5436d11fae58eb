// The message rmw_dds_common/msg/ParticipantEntitiesInfo. On the topic "ros_discovery_info" each process of
// ROS 2 says by it which nodes it has, and which readers and writers of its participant belong to each node.
// Pure functions.
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

/// In the order of the wire: 12 bytes that an entity shares with its participant, and 4 of its own.
using Guid = std::array<std::uint8_t, 16>;

/// The number of bytes that a GUID has in the message. A node that reads a message with GUIDs of 16 bytes as
/// one with 24 may try to allocate gigabytes, and end.
enum class GuidBytes : std::uint8_t {
  as_of_iron = 16,
  before_iron = 24,  ///< from Foxy to Humble; the last 8 are 0
};

/// Returns the number for a distribution of ROS 2 (the value of ROS_DISTRO); nothing if it is unknown.
std::optional<GuidBytes> guid_bytes_of(std::string_view distribution);

struct ParticipantEntities {
  struct Node {
    std::string name_space;  ///< with a leading slash, which may be all of it
    std::string name;
    std::vector<Guid> readers{}, writers{};
  };
  Guid participant{};
  std::vector<Node> nodes{};
};

/// Returns the body of the message, in CDR, little-endian.
std::vector<std::byte> encode_entities(const ParticipantEntities& entities, GuidBytes guid_bytes);

struct ReceivedEntities {
  ParticipantEntities entities;
  GuidBytes guid_bytes{};
};
/// Reads such a body. It fits one of both sizes, up to the padding at its end; the result is empty if it fits
/// none.
std::optional<ReceivedEntities> decode_entities(std::span<const std::byte> body);

}  // namespace sft::core
