// A few nodes whose negotiations talk to each other, in one thread and without time: what the control
// channel, the transports and the reconciler do is modelled, one step at a time, so that a test may choose
// the next step as it likes. After each step the world knows whether something is wrong.
//
// The control channel is reliable and keeps the last of each endpoint and reader: what was overwritten before
// it came may or may not come, and anything may come twice. Between two nodes announcements come in order;
// requests come at any time, and where chance decides, in any order. A node may lose another and find it
// again, which brings all again that the other has to say. Nodes may be killed and come back under new ids.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/negotiation/negotiation.h"
#include "tests/support/test_seed.h"

namespace sft::test {

class NegotiationWorld {
 public:
  struct EndpointPlan {
    std::size_t place = 0;  ///< of the node
    core::Role role{};
    bool may_use_shm = true;
    bool may_use_udp = true;
    core::Qos qos{};
  };
  /// How often each event may happen that is not the protocol's own doing.
  struct Budget {
    int mask_changes = 0;
    int rate_changes = 0;
    int losses = 0;    ///< one node does not hear another any more, for a while
    int silences = 0;  ///< likewise, but only what it says of its life
    int memory_changes = 0;
    int restarts = 0;  ///< killed, and started again
    int departures = 0;
    int repetitions = 0;
    int samples = 0;
  };
  struct Plan {
    std::size_t places = 2;
    std::vector<EndpointPlan> endpoints;
    Budget budget;
    bool common_memory = true;  ///< at the beginning
  };
  enum class What : std::uint8_t {
    announcement_comes,
    request_comes,
    announcement_repeated,
    request_repeated,
    agent_reconciles,
    agent_looks_after_connections,
    daemon_connects,
    mask_changes,
    rate_changes,
    node_lost,
    node_found,
    lost_forgotten,
    memory_changes,
    node_killed,
    node_started,
    endpoint_departs,
    sample_published,
    datagram_comes,
    datagram_lost,
    history_leaves,
    node_falls_silent,
    node_heard_again,
  };
  struct Step {
    What what{};
    std::uint8_t node = 0;   ///< to which it happens
    std::uint8_t other = 0;  ///< where it comes from, or which of several
  };

  /// `type` outlives the world. `random` chooses what a step leaves open; without, the first possibility.
  NegotiationWorld(const Plan& plan, const TypeSupport& type, Random* random = nullptr);

  /// All that may happen next.
  const std::vector<Step>& steps();
  void take(const Step& step);
  /// All nodes find each other again, nothing else happens any more, and what is under way comes; then checks
  /// that both sides of each pair agree, and that every reader is served under exactly what it asks for.
  void settle();
  /// Empty while all is well.
  const std::string& violation() const { return violation_; }
  /// The steps so far.
  std::string history() const;

 private:
  using Id = core::EndpointId;
  struct Announcement {
    Id id = 0;
    std::shared_ptr<const core::Endpoint> endpoint;  ///< null: withdrawn
  };
  struct Channel {
    bool found = false;
    std::deque<Announcement> announcements;
    std::deque<std::shared_ptr<const core::Request>> requests;
    Announcement last_announcement;
    std::shared_ptr<const core::Request> last_request;
  };
  struct Heard {
    bool network = false;
    bool memory = false;
  };
  struct Reader {
    core::Endpoint endpoint;
    std::map<Id, Heard> heard;
    std::vector<Id> connected;   ///< takes datagrams of
    std::vector<Id> let_go;      ///< did so before
    std::vector<Id> subscribed;  ///< in shared memory
    std::vector<Id> fed;
    std::vector<Id> history_came;  ///< from these writers, all of it
  };
  struct Writer {
    core::Endpoint endpoint;
    core::Serving wanted;
    core::Serving in_force;
    bool port = false;
    std::set<Id> history_given;  ///< to these readers
  };
  /// The state that a node was told of an endpoint elsewhere: the specification that its negotiation is held
  /// against.
  struct Told {
    std::shared_ptr<const core::Endpoint> endpoint;
    std::optional<core::Time> lost_since;
    bool silent = false;                  ///< its node says no more that it lives
    std::uint64_t newest = 0;             ///< sequence of a request
    std::uint64_t newest_while_away = 0;  ///< told while there was no endpoint, or it was lost
    bool lost() const { return lost_since || silent; }
  };
  struct Node {
    core::NodeId id = 0;
    std::size_t place = 0;
    bool up = true;
    bool dirty = false;  ///< as the negotiation said
    core::Negotiation negotiation;
    core::Self self;
    core::Time now{};
    std::map<Id, Writer> writers;
    std::map<Id, Reader> readers;
    std::map<Id, std::shared_ptr<const core::Endpoint>> announced;  ///< what others find
    std::map<Id, std::shared_ptr<const core::Request>> sent;
    std::map<Id, Told> told;
    std::vector<Id> opened;  ///< endpoints of this node, those that are gone as well
  };
  struct Datagram {
    Id writer = 0;
    Id reader = 0;
    FieldMask mask;
  };
  struct Asked {
    core::Request request;
    FieldMask mask;  ///< closed
  };

  Channel& channel(std::size_t from, std::size_t to) { return channels_.at({from, to}); }
  bool coin() { return random_ != nullptr && (*random_)() % 2 == 0; }
  void fail(const std::string& what);
  void add(What what, std::size_t node, std::size_t other = 0);
  void steps_of_pair(std::size_t from, std::size_t to);
  void steps_of_node(std::size_t node);

  void start_node(std::size_t place);
  void kill(std::size_t node);
  void add_endpoint(Node& node, const EndpointPlan& plan);
  void depart(std::size_t node, std::size_t which);
  void change_mask(std::size_t node, std::size_t which);
  void change_rate(std::size_t node, std::size_t which);
  void change_memory(std::size_t node, const core::HostToken& host);
  void publish(std::size_t node, std::size_t which);
  void arrive(std::size_t which);
  static bool owes_history(const Writer& writer);
  void give_history(std::size_t node, std::size_t which);
  void fall_silent(std::size_t from, std::size_t to);
  void hear_again(std::size_t from, std::size_t to);
  bool knows_as_silent(std::size_t from, std::size_t to) const;
  void history_comes(Id writer, Id reader, TransportKind path);
  bool has_begun(const Node& node, Id writer, Id reader) const;
  void owe_what_has_not_begun(Node& node, Id reader);
  static void forget_history(Node& node, Id reader);

  void announce(std::size_t node, Id id);
  void send_request(std::size_t node, Id reader);
  void note_request(const core::Negotiation& negotiation, Id reader);
  void post(Channel& channel, Announcement announcement);
  void post(Channel& channel, std::shared_ptr<const core::Request> request);
  void deliver(std::size_t to, const Announcement& announcement);
  void deliver(std::size_t to, const core::Request& request);
  void lose(std::size_t from, std::size_t to);
  void find(std::size_t from, std::size_t to);
  void forget(std::size_t node);

  void reconcile(std::size_t node);
  void reconcile_reader(std::size_t node, Id id, Reader& reader);
  void look_after_connections(std::size_t node);
  bool connect_by_daemon(bool pretend);
  bool connections_changed(const Node& node) const;

  void changed(std::size_t node, bool dirty);
  void check_serving(const Node& node, const Writer& writer);
  std::size_t check_route(const Node& node, const Writer& writer, const core::Endpoint& reader,
                          std::uint64_t newest);
  void find_all_that_are_up();
  bool deliver_all();
  bool connect_all();
  bool give_all();
  void check_agreement();
  void check_pair(const Node& there, const Writer& writer, const Node& here, const Reader& reader);

  const Plan plan_;
  const TypeSupport* type_;
  Random* random_;
  Budget left_;
  Id next_id_ = 1;
  std::vector<Node> nodes_;  ///< dead ones too: their last words may be under way
  std::map<std::pair<std::size_t, std::size_t>, Channel> channels_;  ///< from, to
  std::map<Id, std::vector<Asked>> asked_;                           ///< by sequence
  std::vector<Datagram> datagrams_;
  std::vector<Step> steps_;
  std::vector<Step> taken_;
  std::string violation_;
};

}  // namespace sft::test
