// The nodes of ROS 2 that other processes have named, and the readers and writers that belong to them.
// The memory for the names is bounded, whatever the participants send.
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
  static constexpr std::size_t participants_max = 1024;  ///< further ones are ignored
  static constexpr std::size_t bytes_max = 4 << 20;      ///< of names and endpoints, of all participants

  /// Keeps what a participant says of its nodes, in place of what it said before. `writer` is the handle of
  /// its DDS writer. Returns true if that has changed something. What it says of endpoints of other
  /// participants is ignored.
  bool note(std::uint64_t writer, const Guid& participant, const ReceivedEntities& said);
  /// Forgets what came from that DDS writer. Returns true if something did.
  bool forget(std::uint64_t writer);

  /// Returns the name of the node, as "/left/camera", that a reader or a writer belongs to. The result is
  /// empty if no node is known to have it.
  std::string_view node_of(const Guid& endpoint) const;
  /// Returns true if some participant has sent GUIDs of that size.
  bool uses(GuidBytes guid_bytes) const;

 private:
  using Prefix = std::array<std::uint8_t, 12>;  ///< what the GUIDs of a participant have in common
  using EntityId = std::array<std::uint8_t, 4>;
  struct Participant {
    std::uint64_t writer = 0;
    GuidBytes guid_bytes{};
    std::vector<std::string> nodes{};
    std::vector<std::pair<EntityId, std::uint32_t>> endpoints{};  ///< each with its node; in order
    friend bool operator==(const Participant&, const Participant&) = default;
  };
  static std::pair<Prefix, EntityId> parts_of(const Guid& guid);
  static Participant compact(std::uint64_t writer, const Prefix& prefix, const ReceivedEntities& said);
  static std::size_t bytes_of(const Participant& participant);

  std::map<Prefix, Participant> participants_;
  std::size_t bytes_ = 0;
};

}  // namespace sft::core
