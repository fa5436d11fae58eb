// The endpoints of all processes, ours included, as their records describe them, and which nodes of this
// process are notified of them. A node is notified of the endpoints that may match its own: those of the
// other role, of the same topic. A node that asks for a role is notified of all endpoints of that role. An
// endpoint id belongs to the process that announced it first, until that process withdraws it or is lost.
// Meanwhile other processes cannot announce or change it. Pure: events go in, notices come out. One thread at
// a time.
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

/// A node of this process. Any thread may call its functions; the other members belong to the directory.
struct ListeningNode {
  explicit ListeningNode(DiscoveryListener& of) : listener(of) {}

  /// Calls `call(listener)`, unless close() was called.
  template <class Call>
  void notify(Call call) {
    gate.call([&] { call(listener); });
  }
  /// After it has returned, the listener is not called any more.
  void close() { gate.close(); }

  DiscoveryListener& listener;  ///< must exist until close() was called or this object is destroyed
  CallGate gate{};
  AnnouncerId number = 0;
  PerRole<bool> hears_all{};
  std::set<Inquiry> inquiries{};
  PerRole<std::map<std::string, std::size_t>> topics{};  ///< the number of its endpoints on each topic
};
using ListeningNodes = std::vector<std::shared_ptr<ListeningNode>>;

/// Knows the endpoints and inquiries of all processes, and writes notices for the nodes that they concern.
/// Larger than usual: an event of each kind has a function, for our own nodes as well as for other processes.
class Directory {
 public:
  /// Returns true if the address is in the network of the link.
  using LeadsTo = std::function<bool(LinkId, const IpAddress&)>;
  explicit Directory(LeadsTo leads_to) : leads_to_(std::move(leads_to)) {}

  // Nodes of this process.

  std::shared_ptr<ListeningNode> join(DiscoveryListener& listener);
  /// The node must have withdrawn its endpoints.
  void leave(const std::shared_ptr<ListeningNode>& node) { std::erase(nodes_, node); }
  void hear_all(const std::shared_ptr<ListeningNode>& node, Role role);
  void announced(const std::shared_ptr<ListeningNode>& node, Endpoint endpoint);
  void requested(const Request& request);
  void withdrawn(EndpointId id);
  void inquires(const std::shared_ptr<ListeningNode>& node, std::set<Inquiry> inquiries);
  void reported(const std::shared_ptr<ListeningNode>& node, const NodeReport& report);
  std::vector<EndpointId> endpoints_of(const std::shared_ptr<ListeningNode>& node) const;

  // Other processes.

  void record_changed(const RecordChanged& changed);
  void peer_lost(ProcessId process);
  void paths_cut(const PathsCut& cut);
  /// Passes on only those parts of the report that concern endpoints which the process has announced.
  void report_came(ProcessId process, NodeReport report);
  /// Notifies all nodes that participants which are not SFT's have come or gone.
  void vanilla_changed();
  /// Notifies all nodes that something malformed or forged was refused.
  void refuse(std::string why);
  /// Passes a text for people to that function of all nodes.
  void tell(void (DiscoveryListener::*function)(std::string text), std::string text);

  /// A call that some nodes have to get. Notices are in the order of the events.
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
  using Place = std::tuple<ProcessId, Role, std::uint32_t>;  ///< of a slot; our own endpoints have none
  struct Slot {
    std::optional<Endpoint> endpoint{};
    std::optional<Request> request{};
  };
  struct Entry {
    std::shared_ptr<const Endpoint> endpoint;
    std::optional<Request> request{};       ///< a subscriber's latest, if newer than that in `endpoint`
    std::shared_ptr<ListeningNode> node{};  ///< the node that has it; null: another process has it
    std::optional<Place> place{};           ///< the slot of another process
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
  AnnouncerId last_number_ = AnnouncerId{1} << 63;  ///< of nodes; other processes have their ids
  ListeningNodes nodes_;
  std::map<Place, Slot> slots_;
  std::map<EndpointId, Entry> entries_;
  std::map<Place, Inquiry> inquiries_;  ///< of other processes
  std::uint64_t inquiries_made_ = 0;
  std::map<ProcessId, PathsCut> cut_;
  std::vector<Notice> notices_;
};

}  // namespace sft::core
