// The table of endpoints, ours and those of other nodes, by their ids and by their topics. It knows which
// endpoints are lost. Discovery limits what other processes can announce. Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/control/control.h"
#include "core/platform/clock.h"
#include "sft/selection.h"
#include "sft/type_support.h"

namespace sft::core {

struct TableEntry {
  Endpoint endpoint;
  const TypeSupport* type = nullptr;  ///< the type of an endpoint of ours; null for endpoints of other nodes
  std::optional<Time> lost_since{};   ///< the time since which the endpoint's process does not answer; empty:
                                      ///< the process answers
  std::uint64_t arrival = 0;          ///< the number of the entry in the order of arrival
  std::optional<Progress> progress{};  ///< the last reported progress of a writer
  /// The selection that a reader requests, as it was decoded last for one of our writers. It is kept because
  /// every pair is evaluated again after every event, and decoding takes microseconds.
  struct Decoded {
    const TypeSupport* type = nullptr;
    std::vector<std::uint64_t> mask_words{};
    std::vector<std::byte> parts{};
    Result<Selection> selection{};
  };
  mutable Decoded decoded{};

  bool is_ours() const { return type != nullptr; }
  bool lost() const { return lost_since.has_value(); }
};

class EndpointTable {
 public:
  /// Adds an endpoint of ours. Its id must not be in the table. `type` outlives the entry.
  void add_ours(const Endpoint& endpoint, const TypeSupport& type);
  /// Adds or updates an endpoint of another node, which then does not count as lost.
  void enter(const Endpoint& endpoint);
  /// Removes an entry. Returns false if it was not in the table.
  bool erase(EndpointId id);

  /// Returns the entry; null if there is none with that id.
  TableEntry* find(EndpointId id);
  const TableEntry* find(EndpointId id) const;
  /// Returns the entry; null if there is none with that id, or if it is not ours.
  TableEntry* find_ours(EndpointId id);
  const TableEntry* find_ours(EndpointId id) const;
  std::vector<Endpoint*> ours();
  /// Returns the readers of the entry's topic if the entry is a writer, or the writers if it is a reader.
  std::vector<const TableEntry*> counterparts(const TableEntry& entry) const;
  /// Returns true if some endpoint of ours has the topic.
  bool is_topic_of_ours(std::string_view topic) const;

  /// Marks an endpoint as lost. Returns true if the endpoint is in the table and was not lost before.
  bool lost(EndpointId id, Time now);
  std::vector<EndpointId> lost_for(std::chrono::seconds duration, Time now) const;

  /// Stores the progress of a writer, as its node reports it.
  void progressed(const Progress& progress);

  std::size_t size() const { return entries_.size(); }
  /// Returns all endpoints except the lost ones, including ours. Valid until the next event.
  std::vector<const TableEntry*> present() const;
  /// Returns true if some endpoint is lost.
  bool misses_peer() const { return !lost_.empty(); }

 private:
  struct Topic {
    std::set<EndpointId> endpoints;
    std::size_t ours = 0;  ///< how many of `endpoints` are ours
  };
  void index(const TableEntry& entry);
  void unindex(const TableEntry& entry);

  // Because of these maps, the cost of an event of one endpoint does not depend on the number of other
  // endpoints.
  std::map<EndpointId, TableEntry> entries_;
  std::map<std::string, Topic, std::less<>> topics_;  ///< the topics of all entries
  std::set<EndpointId> lost_;                         ///< the entries that are lost
  std::uint64_t arrivals_ = 0;
};

}  // namespace sft::core
