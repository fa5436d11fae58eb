// The result of Node::snapshot(): all that a node knows about its own publishers and subscribers at one
// time. It is for people, tools and tests.
//
// A snapshot is a copy that the program owns. Any thread may take one, also in callbacks of SFT. The call
// copies the status of all publishers and subscribers one after the other (status.h says what the counts
// mean and when they agree), and writes masks as names of fields. It allocates memory, and takes some
// microseconds for each pair. Publishing and receiving do not wait for it; opening or destroying a
// publisher or subscriber does.
//
// As JSON a snapshot is one object. Later versions keep the names and may add some. Ids are strings of 16 hex
// digits. Durations are in nanoseconds; 0 means none. `fields` are texts as TypeSupport::parse_selection()
// takes them. `transport` is "shm" or "udp", or "dds" for an unmodified DDS writer. It is null for a reader
// that is not served and a writer that is not connected:
//
//   node          name, domain, version, control_protocol, time_ns (CLOCK_REALTIME)
//   shm           ready, state, refused {malformed, over_limit}
//   udp           state, refused {malformed, unknown, incomplete, over_limit}
//   control       refused {malformed, ignored}
//   publishers[]  id, topic, type, qos, fields (encoded at present), published, bytes_sent, bytes_saved,
//                 dropped, diverted {exhausted, too_large, unavailable, too_large_bytes, chunk_bytes},
//                 vanilla_readers,
//                 deadlines_missed, alive, readers[]
//     readers[]   id, node, served, transport, reason, multicast, incompatible_type,
//                 incompatible_policy (null: none), no_path, fields, max_rate_hz, request, published, sent,
//                 withheld, dropped, retained, diverted, bytes_sent, bytes_saved
//   subscribers[] id, topic, selection (its number), type, qos, fields (asked for), recorded, max_rate_hz,
//                 requests, received, lost, withheld, expired, discarded, held_too_many, restarts, writers[]
//     writers[]   id, node, matched, connected, alive, transport, reason, depth, incompatible_type,
//                 incompatible_policy, no_path, received, lost, withheld, expired, deadlines_missed, restarts
//   qos           reliability, durability, history_depth, deadline_ns, lifespan_ns, liveliness,
//                 liveliness_lease_ns
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sft/qos.h"
#include "sft/status.h"

namespace sft {

/// The result of Node::snapshot().
struct NodeSnapshot {
  /// One publisher. Members without a comment are as in PublisherStatus.
  struct Publisher {
    /// One reader of a publisher.
    struct Reader : PublisherStatus::Reader {
      std::string fields{};  ///< the fields that are sent to the reader
    };

    std::uint64_t id = 0;                  ///< the same as DomainSnapshot::Endpoint::id
    std::string topic;                     ///< the name without a slash at the beginning
    std::string type;                      ///< the name of the type
    Qos qos;                               ///< the QoS that the publisher offers
    std::string fields;                    ///< the fields that are encoded at present
    std::uint64_t published = 0;           ///< as in PublisherStatus
    std::uint64_t bytes_sent = 0;          ///< as in PublisherStatus
    std::uint64_t bytes_saved = 0;         ///< as in PublisherStatus
    std::uint64_t dropped = 0;             ///< as in PublisherStatus
    PublisherStatus::Diverted diverted{};  ///< as in PublisherStatus
    std::size_t vanilla_readers = 0;       ///< as in PublisherStatus
    std::uint64_t deadlines_missed = 0;    ///< as in PublisherStatus
    bool alive = true;                     ///< as in PublisherStatus
    std::vector<Reader> readers;           ///< all subscribers of the topic, served or not
  };

  /// One subscriber, with its status. A subscriber with several selections has one entry with a separate id
  /// for each selection.
  struct Subscriber : SubscriberStatus {
    std::uint64_t id = 0;   ///< the same as DomainSnapshot::Endpoint::id
    std::string topic;      ///< the name without a slash at the beginning
    std::string type;       ///< the name of the type
    Qos qos;                ///< the QoS that the subscriber requests
    std::string fields;     ///< the fields that the subscriber requests at present
    bool recorded = false;  ///< true: `fields` were found by recording
    /// The number in SampleInfo::selection of its samples. The entries of one subscriber follow each other.
    std::size_t selection_number = 0;
  };

  /// The full name of the node: NodeOptions::name with the namespace, after remapping.
  std::string name;
  /// The DDS domain.
  std::uint32_t domain = 0;
  std::string version;  ///< the version of this library
  /// The version of the control protocol; nodes with another version are not found.
  std::uint32_t control_protocol = 0;
  /// The time at which the snapshot was taken.
  std::chrono::sys_time<std::chrono::nanoseconds> time{};
  NodeStatus status;                    ///< the state of shared memory and UDP, and counts of refused input
  std::vector<Publisher> publishers;    ///< in the order in which the publishers were opened
  std::vector<Subscriber> subscribers;  ///< in the order in which the subscribers were opened
};

/// Returns the JSON object `qos` of a publisher or subscriber, in one line.
std::string to_json(const Qos& qos);

/// Returns the snapshot as JSON. `indent` is the number of spaces for each level; -1: all in one line. The
/// text is valid UTF-8, even if other nodes have announced invalid names.
std::string to_json(const NodeSnapshot& snapshot, int indent = 2);

}  // namespace sft
