// The state of a world of negotiations: the nodes, their endpoints, and what each node was told of endpoints
// of other nodes. All of it can be copied.
#pragma once

#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "core/negotiation/negotiation.h"
#include "tests/simulation/negotiation/control_channels.h"
#include "tests/simulation/negotiation/negotiation_plan.h"

namespace sft::test {

using Id = core::EndpointId;

core::HostToken host_token(std::uint8_t n);

/// All requests that readers have ever made, each with the selection under which the reader may be served.
class AskedRequests {
 public:
  struct Asked {
    core::Request request;
    Selection selection;  ///< a closed selection
  };

  /// `type` outlives this object.
  explicit AskedRequests(const TypeSupport& type) : type_(&type) {}

  /// `wanted` is the selection that the reader wanted when it made the request, whatever the request says.
  void note(const core::Request& request, const Selection& wanted);
  const Asked& at(Id reader, std::uint64_t sequence) const { return *asked_.at(reader).at(sequence); }
  const Asked& last(Id reader) const { return *asked_.at(reader).back(); }
  bool has_ever_asked_for(Id reader, const Selection& selection) const;

 private:
  const TypeSupport* type_;
  std::map<Id, std::vector<std::shared_ptr<const Asked>>> asked_;  ///< by sequence
};

struct Heard {
  bool network = false;
  bool memory = false;
};
struct WorldReader {
  core::Endpoint endpoint;
  Selection wanted;
  std::map<Id, Heard> heard;
  std::vector<Id> connected;   ///< writers whose datagrams the reader takes
  std::vector<Id> let_go;      ///< writers whose datagrams it took before
  std::vector<Id> subscribed;  ///< writers to whose shared memory it subscribes
  std::vector<Id> fed;
  std::vector<Id> history_came;  ///< writers whose whole history has come
};
struct WorldWriter {
  core::Endpoint endpoint;
  core::Serving wanted;
  core::Serving in_force;
  bool port = false;
  std::set<Id> history_given;  ///< readers that were given the history

  /// Returns true if the history has to be sent to some reader.
  bool owes_history() const;
};
/// What a node was told of an endpoint of another node. Its negotiation is checked against this.
struct Told {
  std::shared_ptr<const core::Endpoint> endpoint;
  std::optional<core::Time> lost_since;
  std::uint64_t newest = 0;  ///< greatest sequence of a request
  bool lost() const { return lost_since.has_value(); }
};
struct WorldNode {
  core::NodeId id = 0;
  std::size_t place = 0;
  bool up = true;
  bool dirty = false;  ///< the agent has work, as the negotiation said
  core::Negotiation negotiation;
  core::Self self;
  core::Time now{};
  std::map<Id, WorldWriter> writers;
  std::map<Id, WorldReader> readers;
  std::map<Id, std::shared_ptr<const core::Endpoint>> announced;  ///< what other nodes find
  std::map<Id, std::shared_ptr<const core::Request>> sent;
  std::map<Id, Told> told;
  std::vector<Id> opened;  ///< endpoints of this node, including departed ones

  /// Returns true if the reader has told this node that the history of the writer has begun to come.
  bool has_begun(Id writer, Id reader, const AskedRequests& asked) const;
  /// Marks the history of each writer as not given to the reader if the reader has not begun to get it. A
  /// reader that lost a writer and found it again begins anew.
  void owe_what_has_not_begun(Id reader, const AskedRequests& asked);
  /// Marks the history as not given to that reader. Its writers treat a reader that comes back as a new one.
  void forget_history(Id reader);
  /// Returns true if some request does not match the connections of its reader.
  bool connections_changed() const;
};
struct Datagram {
  Id writer = 0;
  Id reader = 0;
  Selection selection;
};

struct NegotiationState {
  std::size_t places = 0;
  NegotiationPlan::Budget left{};
  std::vector<WorldNode> nodes{};  ///< also dead ones, whose messages may be under way
  ControlChannels channels;
  AskedRequests asked;
  std::vector<Datagram> datagrams{};

  /// Lets the node `to` find the node `from`, with all its endpoints and requests.
  void find(std::size_t from, std::size_t to);
  /// Lets a writer of that node send a sample to all readers that it serves over the network.
  void publish(std::size_t node, std::size_t writer);
  Datagram take_datagram(std::size_t which);
};

/// A reader that waits until the daemon connects it with a writer's port.
struct Unconnected {
  std::size_t node = 0;
  Id reader = 0;
  Id writer = 0;
};
std::optional<Unconnected> unconnected(const std::vector<WorldNode>& nodes);

/// Returns the n-th item of a map.
template <class Map>
auto& nth(Map& map, std::size_t n) {
  return *std::next(map.begin(), static_cast<std::ptrdiff_t>(n));
}

}  // namespace sft::test
