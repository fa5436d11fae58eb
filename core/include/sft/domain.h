// What the nodes of a domain announce of themselves: all publishers and subscribers that a node has seen, and
// of each pair of them on one topic whether it matches, by which path and why, found by the rules that both
// of them follow. For tools. Of its own publishers and subscribers a node knows more (snapshot.h): what was
// saved, withheld or lost for each reader is counted by the two nodes concerned, and does not travel.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sft/qos.h"
#include "sft/status.h"
#include "sft/typesupport/dynamic_type.h"

namespace sft {

/// Of one publisher, as its node tells every now and then while it has readers.
struct PublisherProgress {
  std::uint64_t samples = 0;  ///< that it has sent to its readers so far
  std::uint64_t bytes = 0;    ///< of their bodies, over the network, for each reader
};

/// One publisher or subscriber.
struct EndpointInfo {
  std::uint64_t id = 0;
  std::uint64_t node_id = 0;  ///< another one for each node, also where names are equal
  std::string node;
  bool is_own = false;  ///< of the node that was asked
  std::string topic;
  std::string type_name;
  std::uint64_t type_hash = 0;
  std::optional<DynamicType> type{};  ///< its fields; nothing where it is too large to be described
  Qos qos;
  bool may_use_shm = false;
  bool may_use_udp = false;
  bool shm_ready = false;                ///< its node has shared memory that the endpoint may use
  bool same_machine = false;             ///< as the node that was asked
  std::vector<std::string> addresses{};  ///< for samples by UDP: "10.0.0.5:40123"

  // Publishers only.
  std::uint64_t max_sample_bytes = 0;
  bool waits = false;  ///< for reliable readers that do not keep up
  std::optional<PublisherProgress> progress{};

  // Subscribers only.
  std::optional<std::string> fields{};  ///< asked for at present; nothing where no type is known to name them
  double max_rate_hz = 0;               ///< asked for; 0: all samples
  std::uint64_t requests = 0;           ///< so far
};

/// A publisher and a subscriber of one topic, as far as anybody can tell from what both announce.
struct PairInfo {
  std::uint64_t publisher = 0;
  std::uint64_t subscriber = 0;
  bool matched = false;    ///< false: `reason` says why
  bool connected = false;  ///< the subscriber says that it hears the publisher, by `transport`
  TransportKind transport{};
  std::string reason{};
  bool incompatible_type = false;
  std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions; "here" is the publisher's
  QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
  bool no_path = false;                             ///< fits, but not the ways that both may use
};

struct DomainSnapshot {
  std::vector<EndpointInfo> publishers;   ///< by topic, then by node
  std::vector<EndpointInfo> subscribers;  ///< likewise
  std::vector<PairInfo> pairs;            ///< in the order of the publishers, then of the subscribers
};

}  // namespace sft
