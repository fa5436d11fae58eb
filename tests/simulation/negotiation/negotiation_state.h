// The state of a world of negotiations: the nodes, their endpoints, and the knowledge of each node about
// endpoints of other nodes. The whole state can be copied.
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

/// All requests that readers have made so far, each with the selection under which the reader may be served.
class AskedRequests {
 public:
  struct Asked {
    core::Request request;
    Selection selection;  ///< a closed selection
  };

  /// `type` outlives this object.
  explicit AskedRequests(const TypeSupport& type) : type_(&type) {}

  /// Records a request. `wanted` is the selection that the reader wanted at that time, which the request need
  /// not contain.
  void note(const core::Request& request, const Selection& wanted);
  const Asked& at(Id reader, std::uint64_t sequence) const { return *asked_.at(reader).at(sequence); }
  const Asked& last(Id reader) const { return *asked_.at(reader).back(); }
  bool has_ever_asked_for(Id reader, const Selection& selection) const;

 private:
  const TypeSupport* type_;
  /// The requests of each reader, by sequence.
  std::map<Id, std::vector<std::shared_ptr<const Asked>>> asked_;
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
  std::vector<Id> let_go;      ///< writers whose datagrams the reader took before
  std::vector<Id> subscribed;  ///< writers to whose shared memory the reader subscribes
  std::vector<Id> fed;
  std::vector<Id> history_came;  ///< writers whose whole history has arrived
};
struct WorldWriter {
  core::Endpoint endpoint;
  core::Serving wanted;
  core::Serving in_force;
  bool port = false;
  std::set<Id> history_given;  ///< readers to which the history was given

  /// Returns true if the history has to be sent to at least one reader.
  bool owes_history() const;
};
/// The messages that a node has received about an endpoint of another node. The tests compare the node's
/// negotiation with these messages.
struct Reported {
  std::shared_ptr<const core::Endpoint> endpoint;
  std::optional<core::Time> lost_since;
  std::uint64_t newest = 0;  ///< the greatest sequence of a request
  bool lost() const { return lost_since.has_value(); }
};
struct WorldNode {
  core::NodeId id = 0;
  std::size_t place = 0;
  bool up = true;
  bool dirty = false;  ///< whether the negotiation has reported work for the agent
  core::Negotiation negotiation;
  core::Self self;
  core::Time now{};
  std::map<Id, WorldWriter> writers;
  std::map<Id, WorldReader> readers;
  std::map<Id, std::shared_ptr<const core::Endpoint>> announced;  ///< endpoints that other nodes find
  std::map<Id, std::shared_ptr<const core::Request>> sent;
  std::map<Id, Reported> reported;
  std::vector<Id> opened;  ///< endpoints of this node, including removed ones

  /// Returns true if a request of the reader, which this node has received, says that the history of the
  /// writer has begun to arrive.
  bool has_begun(Id writer, Id reader, const AskedRequests& asked) const;
  /// Marks the history of each writer as not given to the reader, unless the reader has begun to get this
  /// history. A reader that lost a writer and found it again has not begun.
  void owe_what_has_not_begun(Id reader, const AskedRequests& asked);
  /// Marks the histories as not given to that reader. A reader that comes back counts as a new one for its
  /// writers.
  void forget_history(Id reader);
  /// Returns true if the request of at least one reader does not match the reader's connections.
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
  std::vector<WorldNode> nodes{};  ///< includes dead nodes, whose messages may be under way
  ControlChannels channels;
  AskedRequests asked;
  std::vector<Datagram> datagrams{};

  /// Makes the node `to` find the node `from`, with all endpoints and requests of `from`.
  void find(std::size_t from, std::size_t to);
  /// Makes a writer of that node send a sample to all readers that the writer serves over the network.
  void publish(std::size_t node, std::size_t writer);
  Datagram take_datagram(std::size_t which);
};

/// A reader that waits for the daemon to connect it with a writer's port.
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
