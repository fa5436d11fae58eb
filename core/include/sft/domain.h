// The domain as a node knows it, for tools: all topics, publishers and subscribers that the node has found,
// and for each pair of a publisher and a subscriber whether they match, by which path, and why. The node
// derives the state of a pair by the same rules as the two nodes of the pair. These two nodes count samples
// that were sent, saved, withheld or lost, and report the counts only while a program asks for them
// (AccountInquiry). A node knows more of its own publishers and subscribers (snapshot.h).
//
// DomainSnapshot also contains readers and writers of DDS and ROS 2 that know nothing of SFT, while the node
// has a participant for them (NodeOptions::vanilla_dds): those of topics that nodes of SFT can share with
// them.
//
// All structs are copies that the program owns, made when Node::topics() or Node::domain() was called. Any
// thread may call these functions, including callbacks.
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
  /// One type of a topic, and the nodes that use the type. The lists of nodes contain a node once for each
  /// of its publishers or subscribers.
  struct Type {
    std::string name;        ///< the name as in the IDL: "sensor_msgs::msg::Imu"
    std::uint64_t hash = 0;  ///< equal for equal definitions of the type
    /// The fields of the type; empty if the type is too large to be described.
    std::optional<DynamicType> type{};
    std::vector<std::string> publishers{};   ///< the names of the publishers' nodes
    std::vector<std::string> subscribers{};  ///< the names of the subscribers' nodes
    std::vector<Qos> offered{};              ///< the QoS that each of `publishers` offers, in the same order
    std::vector<Qos> requested{};  ///< the QoS that each of `subscribers` requests, in the same order
  };

  /// The name of the topic, without a slash at the beginning.
  std::string name;
  std::vector<Type> types{};  ///< publishers and subscribers of different types do not match
};

/// While this object or a copy of it lives, this node asks the nodes of all publishers and subscribers of a
/// topic for their counts of each pair. Node::domain() contains the answers. The first answers come after
/// about a second, and are repeated about once a second. A node reports at most 32 accounts at a time; if
/// there are more, they take turns. An inquiry keeps its node alive. Any thread may destroy it.
class [[nodiscard]] AccountInquiry {
 public:
  AccountInquiry() = default;  ///< an inquiry that asks no node for counts

 private:
  friend class core::NodeCore;
  explicit AccountInquiry(std::shared_ptr<const void> asking) : asking_(std::move(asking)) {}
  std::shared_ptr<const void> asking_;
};

/// The result of Node::domain().
struct DomainSnapshot {
  // The nested structs are defined after this struct, because std::optional accepts a nested struct whose
  // members have default values only once the enclosing struct is complete.
  struct Dds;
  struct DdsNode;
  struct Endpoint;
  struct Progress;
  struct Pair;
  struct Account;
  struct Sent;
  struct Received;

  std::vector<Endpoint> publishers;   ///< ordered by topic, then by node
  std::vector<Endpoint> subscribers;  ///< in the same order
  /// The pairs in the order of the publishers, then of the subscribers. Pairs with an endpoint of DDS are
  /// the last ones. No pair consists of two endpoints of DDS.
  std::vector<Pair> pairs;
  std::vector<DdsNode> dds_nodes;  ///< all DDS participants that know nothing of SFT
};

/// The properties that an endpoint which knows nothing of SFT announces by DDS.
struct DomainSnapshot::Dds {
  std::string guid;       ///< in hexadecimal
  std::string topic;      ///< the name in DDS: "rt/points"
  std::string type_name;  ///< the name in DDS: "sensor_msgs::msg::dds_::Imu_"
  /// The hash of the definition as nodes of ROS 2 announce it, "RIHS01_..."; empty: none is announced.
  std::string type_hash{};
};

/// A DDS participant that knows nothing of SFT.
struct DomainSnapshot::DdsNode {
  std::string name;           ///< as Endpoint::node
  std::string host{};         ///< what it says of itself; empty: nothing
  std::string process{};      ///< the same: "talker (4711)"
  std::size_t endpoints = 0;  ///< readers and writers of any topic that have been discovered
};

/// The number of samples that a publisher has sent so far. Its node announces it from time to time while the
/// publisher has readers.
struct DomainSnapshot::Progress {
  std::uint64_t samples = 0;  ///< samples that were sent to readers of the publisher
  /// Bytes of bodies that were sent over the network; a body counts once for each reader.
  std::uint64_t bytes = 0;
};

/// One publisher or subscriber.
/// Larger than usual: each fact has a separate named member for users.
struct DomainSnapshot::Endpoint {
  std::uint64_t id = 0;       ///< random; a new one each time that an endpoint is opened
  std::uint64_t node_id = 0;  ///< a number that differs between nodes, even if their names are equal
  /// The name of the endpoint's node. For an endpoint of DDS: the name of its node in ROS 2, such as
  /// "/left/driver", or "DDS" and the GUID prefix of its participant.
  std::string node;
  bool is_own = false;          ///< true: the endpoint belongs to the node that was asked
  std::string topic;            ///< the name without a slash at the beginning
  std::string given_topic{};    ///< the name that the endpoint's program uses; empty if it equals `topic`
  std::string type_name;        ///< the name as in the IDL: "sensor_msgs::msg::Imu"
  std::uint64_t type_hash = 0;  ///< equal for equal definitions of the type; 0 for an endpoint of DDS
  /// The fields of the type; empty if the type is too large to be described, and for an endpoint of DDS.
  std::optional<DynamicType> type{};
  /// The QoS that a publisher offers or a subscriber requests. DDS does not announce the depth of a
  /// history: for an endpoint of DDS it is 0.
  Qos qos;
  std::optional<Dds> dds{};              ///< not empty: the endpoint knows nothing of SFT
  bool may_use_shm = false;              ///< true: the options of the endpoint allow shared memory
  bool may_use_udp = false;              ///< true: the options of the endpoint allow UDP
  bool shm_ready = false;                ///< true: shared memory is available to the endpoint's node
  bool same_machine = false;             ///< true: the endpoint runs on the host of the node that was asked
  std::vector<std::string> addresses{};  ///< the addresses that receive samples over UDP: "10.0.0.5:40123"

  // The members of publishers only.
  std::uint64_t max_sample_bytes = 0;  ///< the maximum size of a body in bytes
  bool waits = false;                  ///< true: publish() waits for reliable readers that do not keep up
  /// The number of samples that were sent. Nodes report this while the program calls Node::domain() from time
  /// to time. Empty until the publisher's node has reported it.
  std::optional<Progress> progress{};

  // The members of subscribers only.
  std::optional<std::string> fields{};  ///< the fields requested at present; empty: the type is unknown
  double max_rate_hz = 0;               ///< the maximum rate that the subscriber requests; 0: all samples
  std::uint64_t requests = 0;           ///< the number of requests that the subscriber has made
};

/// The counts of the publisher's node for one subscriber, with the meanings of PublisherStatus::Reader.
struct DomainSnapshot::Sent {
  /// The time since these counts arrived; 0 for counts of this node itself.
  std::chrono::nanoseconds age{};
  std::uint64_t sent = 0;         ///< samples that were sent
  std::uint64_t withheld = 0;     ///< samples that conditions or the maximum rate have withheld
  std::uint64_t dropped = 0;      ///< samples that were dropped
  std::uint64_t retained = 0;     ///< retained samples from before the subscriber joined; not contained in
                                  ///< the counts above
  std::uint64_t bytes_sent = 0;   ///< bytes of bodies over the network
  std::uint64_t bytes_saved = 0;  ///< bytes of the fields that were left out of these bodies
  std::uint64_t diverted = 0;     ///< the sent samples that used UDP because shared memory could not take
                                  ///< them
  std::uint64_t too_large_bytes = 0;  ///< as in PublisherStatus::Diverted
  std::uint64_t chunk_bytes = 0;      ///< as in PublisherStatus::Diverted
  friend bool operator==(const Sent&, const Sent&) = default;
};

/// The counts of the subscriber's node for one publisher, with the meanings of SubscriberStatus::Writer.
struct DomainSnapshot::Received {
  std::chrono::nanoseconds age{};  ///< as in Sent
  std::uint64_t received = 0;      ///< samples that were taken or passed to the callback
  std::uint64_t lost = 0;          ///< samples that should have arrived, and did not
  friend bool operator==(const Received&, const Received&) = default;
};

/// The counts that the two nodes of a pair have reported. The counts of a side are empty if the program
/// does not ask for them, or if the node of that side has not answered yet. An answer that the node does
/// not repeat is dropped after 10 s.
struct DomainSnapshot::Account {
  std::optional<Sent> publisher{};       ///< the report of the publisher's node
  std::optional<Received> subscriber{};  ///< the report of the subscriber's node
};

/// A publisher and a subscriber of one topic, as derived from their announcements. Members that have no
/// comment are as in PublisherStatus::Reader.
struct DomainSnapshot::Pair {
  std::uint64_t publisher = 0;   ///< the id of the publisher
  std::uint64_t subscriber = 0;  ///< the id of the subscriber
  bool dds_publisher = false;    ///< true: the publisher is a DDS writer, which reports no counts
  bool dds_subscriber = false;   ///< true: the subscriber is a DDS reader, which reports no counts
  bool matched = false;          ///< false: the publisher and the subscriber do not match, and `reason`
                                 ///< says why
  /// True: the subscriber reports that it is connected, by `transport`. For a pair with an endpoint of DDS:
  /// the node of the other endpoint has a DDS endpoint for it.
  bool connected = false;
  TransportKind transport{};       ///< valid only while the pair is connected
  std::string reason{};            ///< the reason for this transport, or for having none; for people
  bool incompatible_type = false;  ///< true: the names or definitions of the two types differ
  /// Not null if the publisher and the subscriber have different definitions of the type. In its texts,
  /// "here" means the publisher and "there" the subscriber.
  std::shared_ptr<const TypeMismatch> mismatch{};
  /// The first incompatible policy; `reason` names all of them.
  QosPolicy incompatible_policy = QosPolicy::none;
  bool no_path = false;  ///< true: type and QoS are compatible, but no path is allowed to both endpoints
  Account account{};     ///< the counts of both nodes, while the program asks for them (Node::ask_accounts())
};

/// Returns the hash by which nodes of ROS 2 compare definitions, "RIHS01_...". Returns nothing if the type
/// has enumerations, bitmasks or keys, which types of ROS 2 do not have.
std::optional<std::string> ros_type_hash(const DynamicType& type);

}  // namespace sft
