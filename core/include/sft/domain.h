// What the nodes of a domain announce of themselves: all publishers and subscribers that a node has seen, and
// of each pair of them on one topic whether it matches, by which path and why, found by the rules that both
// of them follow. For tools. What was sent, saved, withheld or lost is counted by the two nodes of a pair,
// and they tell it only while somebody asks for it (AccountInquiry). Of its own publishers and subscribers a
// node knows more (snapshot.h).
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sft/dynamic_type.h"
#include "sft/qos.h"
#include "sft/status.h"

namespace sft {

namespace core {
class NodeCore;
}

/// Of one publisher, as its node tells every now and then while it has readers.
struct PublisherProgress {
  std::uint64_t samples = 0;  ///< that it has sent to its readers so far
  std::uint64_t bytes = 0;    ///< of their bodies, over the network, for each reader
};

/// One publisher or subscriber.
struct EndpointInfo {
  std::uint64_t id = 0;                  ///< random; a new one each time that an endpoint is opened
  std::uint64_t node_id = 0;             ///< another one for each node, also where names are equal
  std::string node;                      ///< the name of its node; several nodes may have the same name
  bool is_own = false;                   ///< of the node that was asked
  std::string topic;                     ///< without a slash at the beginning
  std::string type_name;                 ///< as in the IDL: "sensor_msgs::msg::Imu"
  std::uint64_t type_hash = 0;           ///< equal for equal definitions of the type
  std::optional<DynamicType> type{};     ///< its fields; nothing where it is too large to be described
  Qos qos;                               ///< a publisher offers it, a subscriber requests it
  bool may_use_shm = false;              ///< its options allow shared memory
  bool may_use_udp = false;              ///< its options allow UDP
  bool shm_ready = false;                ///< its node has shared memory that the endpoint may use
  bool same_machine = false;             ///< as the node that was asked
  std::vector<std::string> addresses{};  ///< for samples by UDP: "10.0.0.5:40123"

  // Publishers only.
  std::uint64_t max_sample_bytes = 0;           ///< of a body
  bool waits = false;                           ///< for reliable readers that do not keep up
  std::optional<PublisherProgress> progress{};  ///< nothing while its node has not told it

  // Subscribers only.
  std::optional<std::string> fields{};  ///< asked for at present; nothing where no type is known to name them
  double max_rate_hz = 0;               ///< asked for; 0: all samples
  std::uint64_t requests = 0;           ///< so far
};

/// What the publisher's node has counted for one subscriber, as ReaderStatus has it.
struct SentAccount {
  std::chrono::nanoseconds age{};  ///< of what follows: since it came; 0 where the node that is asked counts
  std::uint64_t sent = 0;          ///< samples, and in the three that follow
  std::uint64_t withheld = 0;      ///< for the maximum rate
  std::uint64_t dropped = 0;       ///< a queue or the memory was full, or the system refused
  std::uint64_t retained = 0;      ///< published before the subscriber was there; not in the counts above
  std::uint64_t bytes_sent = 0;    ///< bytes of bodies over the network
  std::uint64_t bytes_saved = 0;   ///< bytes of the fields that were left out of these bodies
};

/// What the subscriber's node has counted of one publisher, as WriterStatus has it.
struct ReceivedAccount {
  std::chrono::nanoseconds age{};  ///< likewise
  std::uint64_t received = 0;      ///< samples taken or given to the callback
  std::uint64_t lost = 0;          ///< samples that should have come
};

/// What the two nodes of a pair have told of it, each for itself: nothing while the program does not ask, or
/// the node has not answered yet. What a node has told is kept for 10 s if it does not tell it again.
struct PairAccount {
  std::optional<SentAccount> publisher{};       ///< what the publisher's node has told
  std::optional<ReceivedAccount> subscriber{};  ///< what the subscriber's node has told
};

/// One type of a topic, and the names of the nodes that use it, one for each publisher and subscriber.
struct TopicType {
  std::string name;
  std::uint64_t hash = 0;
  std::optional<DynamicType> type{};  ///< its fields; nothing where it is too large to be described
  std::vector<std::string> publishers{};
  std::vector<std::string> subscribers{};
};

struct TopicInfo {
  std::string name;
  std::vector<TopicType> types{};  ///< more than one: these publishers and subscribers do not match
};

/// Asks, as long as it or a copy of it lives, the nodes of all publishers and subscribers of a topic for what
/// they have counted of each pair; Node::domain() then has the answers. The question goes with the signs of
/// life that a node gives anyway, as do the answers. So the first ones come after some 0.7 s, 1.3 s at most
/// (4 s where there are peers or no multicast), and are told anew as often. 64 publishers and subscribers are
/// asked at once, and a node tells 32 accounts at once; where there are more they take turns.
///
/// It keeps its node alive. Like a node it may be destroyed by any thread.
class AccountInquiry {
 public:
  AccountInquiry() = default;  ///< asks nobody

 private:
  friend class core::NodeCore;
  explicit AccountInquiry(std::shared_ptr<const void> asking) : asking_(std::move(asking)) {}
  std::shared_ptr<const void> asking_;
};

/// A publisher and a subscriber of one topic, as far as anybody can tell from what both announce.
struct PairInfo {
  std::uint64_t publisher = 0;     ///< EndpointInfo::id
  std::uint64_t subscriber = 0;    ///< EndpointInfo::id
  bool matched = false;            ///< false: `reason` says why
  bool connected = false;          ///< the subscriber says that it hears the publisher, by `transport`
  TransportKind transport{};       ///< means something only while the pair is connected
  std::string reason{};            ///< for the transport, or for there being none; for people
  bool incompatible_type = false;  ///< the names or definitions of their types differ
  std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions; "here" is the publisher's
  QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
  bool no_path = false;                             ///< fits, but not the ways that both may use
  PairAccount account{};  ///< what both nodes have counted, while the program asks (Node::ask_accounts())
};

/// All publishers and subscribers of a DDS domain that a node knows of, and how each pair stands. A copy.
struct DomainSnapshot {
  std::vector<EndpointInfo> publishers;   ///< by topic, then by node
  std::vector<EndpointInfo> subscribers;  ///< likewise
  std::vector<PairInfo> pairs;            ///< in the order of the publishers, then of the subscribers
};

}  // namespace sft
