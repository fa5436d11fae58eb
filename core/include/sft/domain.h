// The domain as a node knows it, for tools: all topics, publishers and subscribers that it has seen, and
// for each pair of a publisher and a subscriber whether they match, by which path, and why. The node finds
// that by the rules that both of them follow. The two nodes of a pair count the samples that were sent,
// saved, withheld or lost; they tell these counts only while somebody asks for them (AccountInquiry). A node
// knows more of its own publishers and subscribers (snapshot.h).
//
// All structs are copies that the program owns, made when Node::topics() or Node::domain() was called. Any
// thread may call these functions, also in callbacks.
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

/// One topic that the node has seen.
struct TopicInfo {
  /// One type of a topic, and the nodes that use it. A list has the name of a node once for each of its
  /// publishers or subscribers.
  struct Type {
    std::string name;                        ///< as in the IDL: "sensor_msgs::msg::Imu"
    std::uint64_t hash = 0;                  ///< equal for equal definitions of the type
    std::optional<DynamicType> type{};       ///< its fields; empty if the type is too large to be described
    std::vector<std::string> publishers{};   ///< names of nodes
    std::vector<std::string> subscribers{};  ///< names of nodes
    std::vector<Qos> offered{};              ///< by each of `publishers`, in their order
    std::vector<Qos> requested{};            ///< by each of `subscribers`, in their order
  };

  /// The name has no slash at its beginning.
  std::string name;
  std::vector<Type> types{};  ///< publishers and subscribers of different types do not match
};

/// Asks the nodes of all publishers and subscribers of a topic for their counts of each pair, as long as it
/// or a copy of it lives; Node::domain() has the answers. The first answers come after a second or so, and
/// are repeated about once a second. A node reports 32 accounts at a time; if there are more, they take
/// turns. An inquiry keeps its node alive. Any thread may destroy it.
class [[nodiscard]] AccountInquiry {
 public:
  AccountInquiry() = default;  ///< asks nobody

 private:
  friend class core::NodeCore;
  explicit AccountInquiry(std::shared_ptr<const void> asking) : asking_(std::move(asking)) {}
  std::shared_ptr<const void> asking_;
};

/// The result of Node::domain().
struct DomainSnapshot {
  // The parts are defined behind this struct, because std::optional takes a part whose members have default
  // values only once the struct around the part is complete.
  struct Endpoint;
  struct Progress;
  struct Pair;
  struct Account;
  struct Sent;
  struct Received;

  std::vector<Endpoint> publishers;   ///< ordered by topic, then by node
  std::vector<Endpoint> subscribers;  ///< in the same order
  std::vector<Pair> pairs;            ///< in the order of the publishers, then of the subscribers
};

/// The amount that a publisher has sent so far. Its node announces it now and then while the publisher has
/// readers.
struct DomainSnapshot::Progress {
  std::uint64_t samples = 0;  ///< samples that were sent to its readers
  std::uint64_t bytes = 0;    ///< bytes of their bodies that went over the network, for each reader
};

/// One publisher or subscriber.
/// Larger than usual: it is a record, whose members have names of their own for users.
struct DomainSnapshot::Endpoint {
  std::uint64_t id = 0;                  ///< random; a new one each time that an endpoint is opened
  std::uint64_t node_id = 0;             ///< different for each node, also if names are equal
  std::string node;                      ///< the name of its node
  bool is_own = false;                   ///< true: it belongs to the node that was asked
  std::string topic;                     ///< without a slash at the beginning
  std::string given_topic{};             ///< the name that its program uses; empty if that is `topic`
  std::string type_name;                 ///< as in the IDL: "sensor_msgs::msg::Imu"
  std::uint64_t type_hash = 0;           ///< equal for equal definitions of the type
  std::optional<DynamicType> type{};     ///< its fields; empty if the type is too large to be described
  Qos qos;                               ///< a publisher offers it, a subscriber requests it
  bool may_use_shm = false;              ///< its options allow shared memory
  bool may_use_udp = false;              ///< its options allow UDP
  bool shm_ready = false;                ///< its node has shared memory that it may use
  bool same_machine = false;             ///< it is on the host of the node that was asked
  std::vector<std::string> addresses{};  ///< where it sends and receives samples by UDP: "10.0.0.5:40123"

  // Publishers only.
  std::uint64_t max_sample_bytes = 0;  ///< of a body
  bool waits = false;                  ///< it waits for reliable readers that do not keep up
  /// Nodes report it while Node::domain() is called now and then; nothing while its node has not.
  std::optional<Progress> progress{};

  // Subscribers only.
  std::optional<std::string> fields{};  ///< that it asks for at present; empty if the type is not known
  double max_rate_hz = 0;               ///< the rate that it asks for; 0: all samples
  std::uint64_t requests = 0;           ///< the number of its requests so far
};

/// The counts of the publisher's node for one subscriber, with the meanings of PublisherStatus::Reader.
struct DomainSnapshot::Sent {
  std::chrono::nanoseconds age{};  ///< the time since the counts came; 0 if the asked node made them itself
  std::uint64_t sent = 0;          ///< samples that were sent
  std::uint64_t withheld = 0;      ///< samples that conditions or the maximum rate have withheld
  std::uint64_t dropped = 0;       ///< samples that were dropped
  std::uint64_t retained = 0;      ///< samples from before the subscriber came; not in the counts above
  std::uint64_t bytes_sent = 0;    ///< bytes of bodies over the network
  std::uint64_t bytes_saved = 0;   ///< bytes of the fields that were left out of these bodies
  std::uint64_t diverted = 0;  ///< a part of `sent`: sent by UDP because shared memory could not take them
  /// As in PublisherStatus::Diverted.
  std::uint64_t too_large_bytes = 0, chunk_bytes = 0;
};

/// The counts of the subscriber's node for one publisher, with the meanings of SubscriberStatus::Writer.
struct DomainSnapshot::Received {
  std::chrono::nanoseconds age{};  ///< as in Sent
  std::uint64_t received = 0;      ///< samples taken or given to the callback
  std::uint64_t lost = 0;          ///< samples that should have come
};

/// The counts that the two nodes of a pair have told. A side is empty if the program does not ask,
/// or if the node has not answered yet. An answer is kept for 10 s if the node does not repeat it.
struct DomainSnapshot::Account {
  std::optional<Sent> publisher{};       ///< what the publisher's node has told
  std::optional<Received> subscriber{};  ///< what the subscriber's node has told
};

/// A publisher and a subscriber of one topic, as far as their announcements tell. Members that have no
/// comment are as in PublisherStatus::Reader.
struct DomainSnapshot::Pair {
  std::uint64_t publisher = 0;     ///< the id of the publisher
  std::uint64_t subscriber = 0;    ///< the id of the subscriber
  bool matched = false;            ///< false: `reason` says why
  bool connected = false;          ///< the subscriber says that it hears the publisher, by `transport`
  TransportKind transport{};       ///< means something only while the pair is connected
  std::string reason{};            ///< for the transport, or for there being none; for people
  bool incompatible_type = false;  ///< the names or definitions of their types differ
  std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions; "here" is the publisher's
  QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
  bool no_path = false;                             ///< all fits, but no path is allowed to both
  Account account{};  ///< what both nodes have counted, while the program asks (Node::ask_accounts())
};

}  // namespace sft
