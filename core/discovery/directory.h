// The endpoints of all processes, ours included, as their records describe them, and the nodes of this
// process that are notified of these endpoints. A node is notified of the endpoints that may match its own:
// those with the other role and the same topic. A node that has called hear_all() for a role is notified of
// all endpoints of that role. An endpoint id belongs to the process that announced it first, until that
// process withdraws it or is lost. Meanwhile other processes cannot announce or change it. The
// directory uses no clock, thread or I/O: it keeps the events of each node until the node takes them. An
// object must be used by only one thread at a time.
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

namespace sft::core {

/// A node of this process. Only the directory uses its members, except `wake`.
struct ListeningNode {
  const std::function<void()> wake;  ///< see Discovery::open()
  std::vector<DiscoveryEvent> events{};
  bool is_woken = false;  ///< true: the node was woken, and has not called take_events() since
  std::map<DiscoveryNews::Kind, DiscoveryNews> refused{};
  PerRole<bool> hears_all{};
  std::set<Inquiry> inquiries{};
  PerRole<std::map<std::string, std::size_t>> topics{};  ///< the number of this node's endpoints on each
                                                         ///< topic
};

/// Knows the endpoints and inquiries of all processes, and notifies the nodes that they concern.
/// Larger than usual: there is a function for each kind of event, of our own nodes and of other
/// processes.
class Directory {
 public:
  /// Returns true if the address is in the network of the link.
  using LeadsTo = std::function<bool(LinkId, const IpAddress&)>;
  explicit Directory(LeadsTo leads_to) : leads_to_(std::move(leads_to)) {}

  // Events of the nodes of this process.

  std::shared_ptr<ListeningNode> join(std::function<void()> wake);
  /// Call this only when the node has withdrawn its endpoints. It is not notified after that.
  void leave(const std::shared_ptr<ListeningNode>& node) { std::erase(nodes_, node); }
  void hear_all(const std::shared_ptr<ListeningNode>& node, Role role);
  void announced(const std::shared_ptr<ListeningNode>& node, Endpoint endpoint);
  /// Returns false if no node has announced the subscriber.
  bool requested(const Request& request);
  /// Returns the role of the endpoint; nothing if no node has announced it.
  std::optional<Role> withdrawn(EndpointId id);
  void inquires(const std::shared_ptr<ListeningNode>& node, std::set<Inquiry> inquiries);
  void reported(const std::shared_ptr<ListeningNode>& node, const NodeReport& report);
  std::vector<EndpointId> endpoints_of(const std::shared_ptr<ListeningNode>& node) const;
  std::vector<DiscoveryEvent> take_events(ListeningNode& node);
  /// Returns the nodes that have to be woken, because there are events for them.
  std::vector<std::shared_ptr<ListeningNode>> take_woken() { return std::exchange(woken_, {}); }

  // Events of other processes.

  void record_changed(const RecordChanged& changed);
  void peer_lost(ProcessId process);
  void paths_cut(const PathsCut& cut);
  /// Passes on the parts of the report that concern endpoints which this process has announced. Other parts
  /// are dropped.
  void report_came(ProcessId process, NodeReport report);
  /// Notifies all nodes that participants which do not belong to SFT have come or gone.
  void vanilla_changed() { give_all(VanillaChanged{}); }
  using News = DiscoveryNews::Kind;
  /// Notifies all nodes. Of refusals, a node gets the number and the text of the first one, however many
  /// there are until it takes them. They do not wake it, since there may be a flood of them.
  void log_news(News news, const std::string& text);

  /// The inquiries of our own nodes and of other processes.
  Discovery::Inquiries inquiries() const;
  bool do_others_inquire() const { return !inquiries_.empty(); }
  std::set<Inquiry> own_inquiries() const;
  std::vector<Discovery::KnownPublisher> publishers_of(std::string_view type_name) const;

 private:
  using Place = std::tuple<ProcessId, Role, std::uint32_t>;  ///< identifies a slot; the process is 0 for
                                                             ///< endpoints of our own nodes
  /// What the records in a slot say.
  struct Entry {
    std::optional<Endpoint> endpoint{};     ///< with the latest request of a subscriber
    std::optional<Request> request{};       ///< the request in the slot, which may come before its endpoint
    std::shared_ptr<ListeningNode> node{};  ///< the node that has the endpoint; null: another process has it
  };
  /// The maximum number of endpoints of one role that another process may announce on one topic. So a process
  /// that announces endpoints without end costs the others on the topic little.
  static constexpr std::size_t topic_share = 256;

  /// Reports that are not urgent do not wake a node unless this number of events has come.
  static constexpr std::size_t unread_max = 64;

  static bool concerns(const ListeningNode& node, const Endpoint& endpoint);
  void wake(const std::shared_ptr<ListeningNode>& node);
  void give(const std::shared_ptr<ListeningNode>& node, DiscoveryEvent event);
  void give_all(const DiscoveryEvent& event);
  void notify(const Entry& entry, const DiscoveryEvent& event);
  void take_announcement(const Place& place, const Record& record);
  void take_request(const Place& place, const Record& record);
  void take_inquiry(const Place& place, const Record& record);
  std::optional<Endpoint> announcement_in(const Record& record, Role role);
  Entry* own(EndpointId id);
  bool owns(const Place& place, const Entry& entry) const;
  void show(const Place& place);
  EndpointSeen seen(const Place& place, const Entry& entry) const;
  void end(const Place& place, const Entry& entry, const DiscoveryEvent& event);
  /// Ends all endpoints of other processes that have this id, because one of our own has it.
  void end_of_others(EndpointId id);
  void leave_out_what_is_cut(ProcessId process, std::vector<UdpAddress>& addresses) const;
  template <class IsOf>
  void notify_report(NodeReport report, const std::shared_ptr<ListeningNode>& by, IsOf is_of);
  std::map<EndpointId, Place> not_heard(const std::shared_ptr<ListeningNode>& node, Role role,
                                        const std::string& topic) const;

  const LeadsTo leads_to_;
  std::vector<std::shared_ptr<ListeningNode>> nodes_, woken_;
  std::map<Place, Entry> entries_;
  std::uint32_t own_slots_made_ = 0;
  /// The entry that each endpoint id belongs to. Nodes are notified of these entries only.
  std::map<EndpointId, Place> owners_;
  /// The same by role and topic.
  std::map<std::pair<Role, std::string>, std::map<EndpointId, Place>> topics_;
  /// The number of these entries of each process, by role and topic.
  std::map<std::tuple<ProcessId, Role, std::string>, std::size_t> shares_;
  std::map<Place, Inquiry> inquiries_;  ///< the inquiries of other processes
  std::uint64_t inquiries_made_ = 0;
  std::map<ProcessId, PathsCut> cut_;
};

}  // namespace sft::core
