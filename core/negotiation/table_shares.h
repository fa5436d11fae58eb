// Limits the number of entries that each announcer has in a table that all processes on the network fill.
// If an announcer enters too many, it loses its own newest entries, and no other announcer loses any:
//
// - While the table is not full, announcers may enter any number, with one exception: once a topic has
//   `topic_shares_from` entries, no announcer gets more than `of_topic` of these.
// - When the table is full, an announcer that has `of_announcer` entries gets no more. Other announcers
//   still do: for each new entry, the announcer that has the most entries loses its newest one.
//
// Uses no clock, thread or I/O.
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
    std::optional<EndpointId> instead_of{};  ///< the entry that has to be removed, so that the new entry can
                                             ///< be admitted
  };
  /// Decides whether an entry that is not in the table is admitted.
  Admission admit(AnnouncerId announcer, std::string_view topic) const;

  void enter(EndpointId id, AnnouncerId announcer, std::string_view topic);
  /// Does nothing if the entry is not in the table.
  void remove(EndpointId id);

  std::size_t size() const { return entries_.size(); }
  std::size_t of(AnnouncerId announcer) const;
  /// Returns the announcer that has entered an entry; null if the entry is not in the table.
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
  using Newest = std::map<std::uint64_t, EndpointId>;  ///< entries in the order of their arrival
  bool has_room(AnnouncerId announcer, std::string_view topic) const;

  Limits limits_;
  std::map<EndpointId, Entry> entries_;
  std::map<AnnouncerId, Newest> announcers_;
  std::map<std::string, Topic, std::less<>> topics_;
  std::uint64_t arrivals_ = 0;
};

}  // namespace sft::core
