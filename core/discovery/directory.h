// The endpoints of all processes, ours included, as their records describe them, and the nodes of this
// process that are notified of these endpoints. A node is notified of the endpoints that may match its own:
// those with the other role and the same topic. A node that has called hear_all() for a role is notified of
// all endpoints of that role. An endpoint id belongs to the process that announced it first, until that
// process withdraws it or is lost. Meanwhile other processes cannot announce or change it. Pure: events are
// passed in, notices are returned. An object must be used by only one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/discovery.h"
#include "core/discovery/peers.h"
#include "core/sync/guarded_call.h"

namespace sft::core {

/// A node of this process. Any thread may call its functions; only the directory uses the other members.
struct ListeningNode {
  explicit ListeningNode(DiscoveryListener& of) : listener(of) {}

  /// Calls `call(listener)`, unless close() was called.
  template <class Call>
  void notify(Call call) {
    gate.call([&] { call(listener); });
  }
  /// After close() has returned, the listener is not called any more.
  void close() { gate.close(); }

  DiscoveryListener& listener;  ///< must exist until close() has returned or this object is destroyed
  CallGate gate{};
  AnnouncerId number = 0;
  PerRole<bool> hears_all{};
  std::set<Inquiry> inquiries{};
  PerRole<std::map<std::string, std::size_t>> topics{};  ///< the number of this node's endpoints on each
                                                         ///< topic
};
using ListeningNodes = std::vector<std::shared_ptr<ListeningNode>>;

/// Knows the endpoints and inquiries of all processes, and writes notices for the nodes that they concern.
/// Larger than usual: there is a function for each kind of event, of our own nodes and of other
/// processes.
class Directory {
 public:
  /// Returns true if the address is in the network of the link.
  using LeadsTo = std::function<bool(LinkId, const IpAddress&)>;
  explicit Directory(LeadsTo leads_to) : leads_to_(std::move(leads_to)) {}

  // Events of the nodes of this process.

  std::shared_ptr<ListeningNode> join(DiscoveryListener& listener);
  /// Call this only when the node has withdrawn its endpoints.
  void leave(const std::shared_ptr<ListeningNode>& node) { std::erase(nodes_, node); }
  void hear_all(const std::shared_ptr<ListeningNode>& node, Role role);
  void announced(const std::shared_ptr<ListeningNode>& node, Endpoint endpoint);
  void requested(const Request& request);
  void withdrawn(EndpointId id);
  void inquires(const std::shared_ptr<ListeningNode>& node, std::set<Inquiry> inquiries);
  void reported(const std::shared_ptr<ListeningNode>& node, const NodeReport& report);
  std::vector<EndpointId> endpoints_of(const std::shared_ptr<ListeningNode>& node) const;

  // Events of other processes.

  void record_changed(const RecordChanged& changed);
  void peer_lost(ProcessId process);
  void paths_cut(const PathsCut& cut);
  /// Passes on the parts of the report that concern endpoints which this process has announced. Other parts
  /// are dropped.
  void report_came(ProcessId process, NodeReport report);
  /// Notifies all nodes that participants which do not belong to SFT have come or gone.
  void vanilla_changed();
  /// Notifies all nodes that a malformed or forged record was refused.
  void refuse(std::string why);
  /// Calls that function of the listeners of all nodes with a text for people.
  void tell(void (DiscoveryListener::*function)(std::string text), std::string text);

  /// A call that has to be made to the listeners of some nodes. Notices are in the order of the events.
  struct Notice {
    ListeningNodes to;
    std::function<void(DiscoveryListener&)> call;
  };
  std::vector<Notice> take_notices() { return std::exchange(notices_, {}); }

  /// The inquiries of our own nodes and of other processes.
  Discovery::Inquiries inquiries() const;
  bool do_others_inquire() const { return !inquiries_.empty(); }
  std::set<Inquiry> own_inquiries() const;
  std::vector<Discovery::KnownPublisher> publishers_of(std::string_view type_name) const;

 private:
  using Place = std::tuple<ProcessId, Role, std::uint32_t>;  ///< identifies a slot of another process; our
                                                             ///< own endpoints have none
  struct Slot {
    std::optional<Endpoint> endpoint{};
    std::optional<Request> request{};
  };
  struct Entry {
    std::shared_ptr<const Endpoint> endpoint;
    std::optional<Request> request{};       ///< the latest request of a subscriber, if it is newer than that
                                            ///< in `endpoint`
    std::shared_ptr<ListeningNode> node{};  ///< the node that has the endpoint; null: another process has it
    std::optional<Place> place{};           ///< the slot, if another process has the endpoint
  };
  enum class End : std::uint8_t { withdrawn, lost };

  static bool concerns(const ListeningNode& node, const Endpoint& endpoint);
  ListeningNodes concerned_by(const Entry& entry) const;
  void take_announcement(const Place& place, const Record& record);
  void take_request(const Place& place, const Record& record);
  void take_inquiry(const Place& place, const Record& record);
  void show(const Place& place);
  void end(EndpointId id, End how);
  void show_next(EndpointId id);
  void leave_out_what_is_cut(ProcessId process, std::vector<UdpAddress>& addresses) const;
  void notify(ListeningNodes to, std::function<void(DiscoveryListener&)> call);
  void notify_seen(ListeningNodes to, const Entry& entry);
  template <class IsOf>
  void notify_report(NodeReport report, const std::shared_ptr<ListeningNode>& by, IsOf is_of);
  void notify_departed(ListeningNodes to, EndpointId id);
  template <class Which>
  void notify_of_all(const std::shared_ptr<ListeningNode>& node, Which which);

  const LeadsTo leads_to_;
  AnnouncerId last_number_ = AnnouncerId{1} << 63;  ///< the last number that a node has got; other processes
                                                    ///< are identified by their ids
  ListeningNodes nodes_;
  std::map<Place, Slot> slots_;
  std::map<EndpointId, Entry> entries_;
  std::map<Place, Inquiry> inquiries_;  ///< the inquiries of other processes
  std::uint64_t inquiries_made_ = 0;
  std::map<ProcessId, PathsCut> cut_;
  std::vector<Notice> notices_;
};

}  // namespace sft::core
