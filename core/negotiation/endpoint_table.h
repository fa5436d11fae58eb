// The table of endpoints, ours and those of other nodes, by their ids and by their topics. It knows which
// endpoints are lost, and admits endpoints of other nodes while there is room for them. Pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "core/negotiation/description_room.h"
#include "core/negotiation/table_shares.h"
#include "core/platform/clock.h"
#include "sft/type_support.h"

namespace sft::core {

struct TableEntry {
  Endpoint endpoint;
  const TypeSupport* type = nullptr;  ///< of our own endpoints
  std::optional<Time> lost_since{};  ///< while its process does not answer: if that returns, it is seen again
  std::uint64_t arrival = 0;         ///< the place of the entry in the order of arrival
  std::optional<Progress> progress{};  ///< of writers, as it was told last

  bool is_ours() const { return type != nullptr; }
  bool lost() const { return lost_since.has_value(); }
};

class EndpointTable {
 public:
  explicit EndpointTable(const TableShares::Limits& limits) : shares_(limits) {}

  /// The id must not be in the table. `type` outlives the entry.
  void add_ours(const Endpoint& endpoint, const TypeSupport& type);
  /// Decides whether a newcomer of another node may enter, and counts the one that is refused or removed. The
  /// caller erases the entry that has to be removed.
  TableShares::Admission admit(const Endpoint& newcomer);
  /// An endpoint of another node is there, for the first time or again. Returns what was known of it before.
  std::optional<Endpoint> enter(const Endpoint& endpoint);
  /// Returns false if it was not in the table.
  bool erase(EndpointId id);

  /// Null if there is none of that id.
  TableEntry* find(EndpointId id);
  const TableEntry* find(EndpointId id) const;
  /// Null if there is none of that id, or if it is not ours.
  TableEntry* find_ours(EndpointId id);
  const TableEntry* find_ours(EndpointId id) const;
  std::vector<Endpoint*> ours();
  /// The readers of a writer's topic, or the writers of a reader's topic.
  std::vector<const TableEntry*> counterparts(const TableEntry& entry) const;
  /// Returns true if some endpoint of ours has the topic.
  bool is_topic_of_ours(std::string_view topic) const;

  /// Returns whether anything has changed.
  bool lost(EndpointId id, Time now);
  std::vector<EndpointId> lost_for(std::chrono::seconds duration, Time now) const;

  /// Takes the progress of a writer, as its node reports it.
  void progressed(const Progress& progress);
  /// Null while nothing was told of that. Valid until the next event.
  const Progress* progress_of(EndpointId id) const;

  std::size_t size() const { return entries_.size(); }
  /// All endpoints but the lost ones; ours too. Valid until the next event.
  std::vector<const Endpoint*> present() const;
  /// Null if there is none of that id. Valid until the next event.
  const Endpoint* known(EndpointId id) const;
  /// Returns true if some endpoint is lost.
  bool misses_peer() const { return !lost_.empty(); }

  /// Announcements that were refused, and entries that were removed, because the table was full.
  std::uint64_t refused() const { return refused_; }
  /// The same by the name of the node that they came from, since this was last asked.
  std::map<std::string, std::uint64_t> take_refusals() { return std::exchange(refusals_, {}); }

 private:
  struct Topic {
    std::set<EndpointId> endpoints;
    std::size_t ours = 0;  ///< of the endpoints
  };
  void index(const TableEntry& entry);
  void unindex(const TableEntry& entry);
  void refuse(const Endpoint& endpoint);

  // An event of one endpoint is looked up in these, whatever the number of the others is.
  std::map<EndpointId, TableEntry> entries_;
  std::map<std::string, Topic, std::less<>> topics_;  ///< of all entries
  std::set<EndpointId> lost_;                         ///< the entries that are lost
  TableShares shares_;                                ///< of those that are not ours
  DescriptionRoom descriptions_;                      ///< room for descriptions of remote endpoints
  std::uint64_t arrivals_ = 0;
  std::uint64_t refused_ = 0;
  std::map<std::string, std::uint64_t> refusals_;
};

}  // namespace sft::core
