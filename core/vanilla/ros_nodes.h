// The nodes of ROS 2 that other processes have announced, and the readers and writers of these nodes. The
// memory for the names is limited, whatever the participants send.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/vanilla/participant_entities.h"

namespace sft::core {

class RosNodes {
 public:
  static constexpr std::size_t participants_max = 1024;  ///< further participants are ignored
  /// The maximum size of the names and endpoints of all participants
  static constexpr std::size_t bytes_max = 4 << 20;

  /// Stores the nodes that a participant has announced, and drops its earlier announcement. `writer` is the
  /// handle of the participant's DDS writer. Returns true if this has changed the stored nodes. Announced
  /// endpoints of other participants are ignored.
  bool note(std::uint64_t writer, const Guid& participant, const ReceivedEntities& said);
  /// Removes the announcement that came from this DDS writer. Returns true if there was one.
  bool forget(std::uint64_t writer);

  /// Returns the name of the node to which a reader or a writer belongs, such as "/left/camera". The result
  /// is empty if no such node is known.
  std::string_view node_of(const Guid& endpoint) const;
  /// Returns true if some participant has sent GUIDs of this size.
  bool uses(GuidBytes guid_bytes) const;

 private:
  /// The first bytes, which all GUIDs of a participant have in common
  using Prefix = std::array<std::uint8_t, 12>;
  using EntityId = std::array<std::uint8_t, 4>;
  struct Participant {
    std::uint64_t writer = 0;
    GuidBytes guid_bytes{};
    std::vector<std::string> nodes{};
    /// The endpoints in ascending order, each with the number of its node
    std::vector<std::pair<EntityId, std::uint32_t>> endpoints{};
    friend bool operator==(const Participant&, const Participant&) = default;
  };
  static std::pair<Prefix, EntityId> parts_of(const Guid& guid);
  static Participant compact(std::uint64_t writer, const Prefix& prefix, const ReceivedEntities& said);
  static std::size_t bytes_of(const Participant& participant);

  std::map<Prefix, Participant> participants_;
  std::size_t bytes_ = 0;
};

}  // namespace sft::core
