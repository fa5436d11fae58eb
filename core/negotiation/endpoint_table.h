// The table of endpoints, ours and those of other nodes, by their ids and by their topics. It knows which
// endpoints are lost, and admits endpoints of other nodes while there is room for them. Uses no clock, thread
// or I/O.
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
  const TypeSupport* type = nullptr;  ///< the type of our own endpoint; null for endpoints of other nodes
  std::optional<Time> lost_since{};   ///< the time since which its process does not answer; empty: it answers
  std::uint64_t arrival = 0;          ///< the place of the entry in the order of arrival
  std::optional<Progress> progress{};  ///< the last reported progress of a writer

  bool is_ours() const { return type != nullptr; }
  bool lost() const { return lost_since.has_value(); }
};

class EndpointTable {
 public:
  explicit EndpointTable(const TableShares::Limits& limits) : shares_(limits) {}

  /// Adds an endpoint of ours. Its id must not be in the table. `type` outlives the entry.
  void add_ours(const Endpoint& endpoint, const TypeSupport& type);
  /// Decides whether a new endpoint of another node is admitted, and counts an endpoint that is refused or
  /// removed. The caller erases the entry that has to be removed.
  TableShares::Admission admit(const Endpoint& newcomer);
  /// Adds or updates an endpoint of another node, which is then not lost. Returns what was known of it
  /// before.
  std::optional<Endpoint> enter(const Endpoint& endpoint);
  /// Removes an entry. Returns false if it was not in the table.
  bool erase(EndpointId id);

  /// Returns the entry; null if there is none with that id.
  TableEntry* find(EndpointId id);
  const TableEntry* find(EndpointId id) const;
  /// Returns the entry; null if there is none with that id, or if it is not ours.
  TableEntry* find_ours(EndpointId id);
  const TableEntry* find_ours(EndpointId id) const;
  std::vector<Endpoint*> ours();
  /// Returns the readers of a writer's topic, or the writers of a reader's topic.
  std::vector<const TableEntry*> counterparts(const TableEntry& entry) const;
  /// Returns true if some endpoint of ours has the topic.
  bool is_topic_of_ours(std::string_view topic) const;

  /// Marks an endpoint as lost. Returns true if that changes anything.
  bool lost(EndpointId id, Time now);
  std::vector<EndpointId> lost_for(std::chrono::seconds duration, Time now) const;

  /// Stores the progress of a writer, as its node reports it.
  void progressed(const Progress& progress);
  /// Returns the progress of a writer; null while none was reported. Valid until the next event.
  const Progress* progress_of(EndpointId id) const;

  std::size_t size() const { return entries_.size(); }
  /// Returns all endpoints except the lost ones, including ours. Valid until the next event.
  std::vector<const Endpoint*> present() const;
  /// Returns the endpoint; null if there is none with that id. Valid until the next event.
  const Endpoint* known(EndpointId id) const;
  /// Returns true if some endpoint is lost.
  bool misses_peer() const { return !lost_.empty(); }

  /// Returns how many announcements were refused, and entries removed, because the table was full.
  std::uint64_t refused() const { return refused_; }
  /// Returns the same number for each node that announced them, by its name, since the last call.
  std::map<std::string, std::uint64_t> take_refusals() { return std::exchange(refusals_, {}); }

 private:
  struct Topic {
    std::set<EndpointId> endpoints;
    std::size_t ours = 0;  ///< how many of `endpoints` are ours
  };
  void index(const TableEntry& entry);
  void unindex(const TableEntry& entry);
  void refuse(const Endpoint& endpoint);

  // With these maps the cost of an event of one endpoint does not depend on the number of other endpoints.
  std::map<EndpointId, TableEntry> entries_;
  std::map<std::string, Topic, std::less<>> topics_;  ///< the topics of all entries
  std::set<EndpointId> lost_;                         ///< the entries that are lost
  TableShares shares_;                                ///< the shares of the entries of other nodes
  DescriptionRoom descriptions_;                      ///< room for descriptions of remote endpoints
  std::uint64_t arrivals_ = 0;
  std::uint64_t refused_ = 0;
  std::map<std::string, std::uint64_t> refusals_;
};

}  // namespace sft::core
