// Limits how much each participant may enter into a table that everybody on the network fills. A participant
// that enters without end loses its own newest entries, and no other participant loses any:
//
// - While the table has room, everybody may enter as much as it likes, with one exception: once a topic has
// `topic_shares_from` entries, no announcer gets more than `of_topic` of these.
// - When the table is full, an announcer that has `of_announcer` entries gets no more. Another announcer
// does: the announcer that has the most entries then loses its newest one.
//
// The class is pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/control/control.h"

namespace sft::core {

class TableShares {
 public:
  struct Limits {
    std::size_t entries = 4096;
    std::size_t of_announcer = 1024;
    std::size_t topic_shares_from = 256;
    std::size_t of_topic = 256;
  };
  TableShares() : TableShares(Limits{}) {}
  explicit TableShares(const Limits& limits) : limits_(limits) {}

  struct Admission {
    bool granted = false;
    std::optional<EndpointId> instead_of{};  ///< the entry that has to be removed for it
  };
  /// Decides about an entry that is not in the table.
  Admission admit(AnnouncerId announcer, std::string_view topic) const;

  void enter(EndpointId id, AnnouncerId announcer, std::string_view topic);
  /// Nothing happens if the entry is not in the table.
  void remove(EndpointId id);

  std::size_t size() const { return entries_.size(); }
  std::size_t of(AnnouncerId announcer) const;
  /// Null if it is not in the table.
  const AnnouncerId* announcer_of(EndpointId id) const;

 private:
  struct Entry {
    AnnouncerId announcer = 0;
    std::uint64_t arrival = 0;
    std::string topic;
  };
  struct Topic {
    std::size_t entries = 0;
    std::map<AnnouncerId, std::size_t> of;
  };
  using Newest = std::map<std::uint64_t, EndpointId>;  ///< by arrival
  bool has_room(AnnouncerId announcer, std::string_view topic) const;

  Limits limits_;
  std::map<EndpointId, Entry> entries_;
  std::map<AnnouncerId, Newest> announcers_;
  std::map<std::string, Topic, std::less<>> topics_;
  std::uint64_t arrivals_ = 0;
};

}  // namespace sft::core
