// The results of publish() and shrink(), and the status of nodes, publishers and subscribers: what was
// negotiated and what was counted.
//
// A status is a copy of what was true when status() was called; the program owns it. Any thread may call
// status(), also in callbacks of SFT. The call takes a short lock of its own and copies, which takes some
// microseconds, and longer with many peers. Publishing and receiving do not wait for it. NodeSnapshot
// (snapshot.h) has the status of all publishers and subscribers of a node at once.
//
// Counts only grow. They are read one after the other while samples are sent, so that a sample on its way may
// already be in one count and not yet in another. When no sample is on its way they agree exactly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sft/mask.h"
#include "sft/qos.h"
#include "sft/selection.h"

namespace sft {

/// The path of samples: shared memory within a host, UDP, or DDS from a writer that knows nothing of SFT.
enum class TransportKind : std::uint8_t { shm, udp, dds };
constexpr const char* to_string(TransportKind kind) {
  if (kind == TransportKind::dds) return "dds";
  return kind == TransportKind::shm ? "shm" : "udp";
}

/// Two definitions of one type; their publishers and subscribers never match. "Here" is the program whose
/// status this is. All texts are empty if this definition was not compared because too many others had been
/// announced.
struct TypeMismatch {
  std::string difference;  ///< the first difference: "fields[].offset: uint32 here, uint64 there"
  std::string here;        ///< the whole type here, as IDL
  std::string there;       ///< the whole type there; empty, like `difference`, if it was not described
};

/// The result of publishing a message.
enum class PublishStatus : std::uint8_t {
  ok,
  /// Nothing was sent: a string has a NUL in it, a bound is exceeded, or the sample is larger than
  /// PublisherOptions::max_sample_bytes. Publisher::why_invalid() names the field.
  invalid,
  no_loan,    ///< nothing was sent: the loan was published already, or moved away
  no_memory,  ///< nothing was sent: no chunk or buffer is free, because readers hold too many samples
  /// A queue was full or no chunk was free, so that at least one reader misses this sample and counts it as
  /// lost. With PublisherOptions::max_blocking publish() has waited that long, and the reader may have lost
  /// an older sample instead.
  dropped,
  /// Nothing was sent: this process is a copy (fork()) of the process that opened the publisher, and has none
  /// of its threads.
  forked,
};
/// Returns a sentence about the status, which lives as long as the program.
const char* to_string(PublishStatus status);

/// The result of publish(span).
struct PublishedSpan {
  std::size_t published = 0;                 ///< the number of messages with the status ok
  PublishStatus status = PublishStatus::ok;  ///< the status of the first message that was not ok; else ok
};

/// The result of Loan::shrink().
enum class ShrinkStatus : std::uint8_t {
  ok,
  not_reserved,  ///< nothing was changed: the loan named no size for this sequence
  too_long,      ///< nothing was changed: the length is more than what was reserved
  no_loan,       ///< nothing was changed: the loan was published already, or moved away
};
/// Returns a sentence about the status, which lives as long as the program.
const char* to_string(ShrinkStatus status);

/// One publisher.
struct PublisherStatus {
  /// One subscriber of the topic, as the publisher serves it.
  /// Larger than usual: it is a record, whose counters have names of their own for users.
  struct Reader {
    std::uint64_t id = 0;       ///< DomainSnapshot::Endpoint::id of the subscriber
    std::string node;           ///< the name of its node
    bool served = false;        ///< false: `reason` says why nothing is sent
    TransportKind transport{};  ///< valid only while the reader is served
    /// Why this transport is used, or why the reader is not served; also says if its host does not answer.
    std::string reason{};
    /// If the reader is served by UDP: which readers share its multicast group, or why it shares none.
    std::string multicast{};
    bool incompatible_type = false;                   ///< the names or definitions of the types differ
    std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions of one type
    QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
    bool no_path = false;                             ///< type and QoS fit, but no path is allowed to both
    bool no_path_yet = false;  ///< no_path, but shared memory may still become available, on either side
    FieldMask mask{};          ///< the fields that are sent to it
    Selection selection{};     ///< these fields, with the parts that it asks for
    double max_rate_hz = 0;    ///< the rate that it asks for; 0: all samples
    std::uint64_t request_sequence = 0;  ///< the number of its request that is in force

    // Samples since the reader was first served, over all its requests and all its paths. Samples that were
    // queued for it when its route changed count as sent.
    std::uint64_t published = 0;  ///< published while the reader was served: sent + withheld + dropped
    std::uint64_t sent = 0;       ///< put into shared memory, passed to the system, or queued for that
    std::uint64_t withheld = 0;   ///< not sent, because of conditions or max_rate_hz
    std::uint64_t dropped = 0;    ///< not sent: a queue or the memory was full, or the system refused
    std::uint64_t retained = 0;   ///< older ones that a durable publisher sent first; not in the counts above
    std::uint64_t diverted = 0;  ///< the part of `sent` that went by UDP as shared memory could not take them

    // Bytes of the bodies that went over the network or the loopback, without headers. A sample in shared
    // memory counts neither as sent nor as saved. If several readers of a process ask for the same fields,
    // bytes that are sent once count for each of these readers.
    std::uint64_t bytes_sent = 0;  ///< see above
    /// The size of the same samples with all fields, minus bytes_sent.
    std::uint64_t bytes_saved = 0;
    friend bool operator==(const Reader&, const Reader&) = default;
  };

  /// The numbers of samples that shared memory could not take, by reason. They went by UDP to the readers
  /// that may use UDP; the other readers missed them.
  struct Diverted {
    std::uint64_t exhausted = 0;        ///< readers, loans and the history held all chunks of that size
    std::uint64_t too_large = 0;        ///< the sample was larger than the largest chunk
    std::uint64_t unavailable = 0;      ///< the daemon had just ended, or held a lock
    std::uint64_t too_large_bytes = 0;  ///< the size of the largest sample that was too large
    std::uint64_t chunk_bytes = 0;      ///< the largest sample that had room in a chunk then
    /// Returns the number of such samples, for any reason.
    std::uint64_t total() const { return exhausted + too_large + unavailable; }
    friend bool operator==(const Diverted&, const Diverted&) = default;
  };

  std::uint64_t id = 0;           ///< DomainSnapshot::Endpoint::id of the publisher
  std::uint64_t published = 0;    ///< the number of samples
  std::uint64_t bytes_sent = 0;   ///< bytes of bodies and SFT headers over the network, each datagram once
  std::uint64_t bytes_saved = 0;  ///< the sum over all readers, also those that are gone
  std::uint64_t deadlines_missed = 0;  ///< periods of its own deadline without a sample
  bool alive = true;                   ///< false: it did not assert its liveliness in time
  /// Samples that at least one transport did not take, and samples that UDP queued and then could not send.
  /// The latter count once for each address that missed one.
  std::uint64_t dropped = 0;
  /// Samples that shared memory could not take.
  Diverted diverted{};
  FieldMask mask;  ///< the fields of a sample that are encoded at present
  /// The number of unmodified readers of DDS and ROS 2 that are served at present. `readers` does not have
  /// them.
  std::size_t vanilla_readers = 0;
  /// All subscribers of the topic, served or not. A subscriber with several selections has one entry for
  /// each.
  std::vector<Reader> readers;
};

/// One subscriber. Sample counts are over all publishers, also those that are gone.
struct SubscriberStatus {
  /// One publisher of the topic, as the subscriber receives from it.
  struct Writer {
    std::uint64_t id = 0;  ///< DomainSnapshot::Endpoint::id of the publisher
    /// The name of its node. An unmodified writer of DDS or ROS 2 has "DDS" and the GUID prefix of its
    /// participant.
    std::string node;
    bool matched = false;       ///< false: `reason` says why
    bool connected = false;     ///< its samples arrive, by `transport`
    bool alive = true;          ///< false: its lease or that of its node is over; `reason` says which
    TransportKind transport{};  ///< valid only while the publisher is connected
    std::string reason{};       ///< why this transport is used, or none; for people
    /// The number of its samples that are kept until they are taken: SubscriberOptions::depth, or less if
    /// shared memory keeps less.
    std::uint32_t depth = 0;
    bool incompatible_type = false;                   ///< the names or definitions of the types differ
    std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions of one type
    QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
    bool no_path = false;                             ///< type and QoS fit, but no path is allowed to both
    bool no_path_yet = false;    ///< no_path, but shared memory may still become available, on either side
    std::uint64_t received = 0;  ///< samples that were taken or passed to the callback
    std::uint64_t lost = 0;      ///< samples that should have come, and did not
    std::uint64_t withheld = 0;  ///< samples that conditions or max_rate_hz have withheld
    std::uint64_t expired = 0;   ///< samples that were not delivered because their lifespan was over
    std::uint64_t deadlines_missed = 0;  ///< periods of the subscriber's deadline without its samples
    /// How often the connection was set up anew because the publisher sent and nothing arrived.
    std::uint64_t restarts = 0;
  };

  std::uint64_t received = 0;  ///< samples that were taken or passed to the callback
  /// Samples that should have come, and did not. Samples of departed publishers count if they were not taken
  /// in time.
  std::uint64_t lost = 0;
  std::uint64_t withheld = 0;  ///< samples that conditions or max_rate_hz have withheld
  std::uint64_t expired = 0;   ///< samples that were not delivered because their lifespan was over
  /// Samples that arrived and were discarded: malformed ones, and those that a full queue pushed out. The
  /// latter count as lost, too, once a later sample is taken.
  std::uint64_t discarded = 0;
  /// How often the program held SubscriberOptions::max_held samples of a publisher and could not take the
  /// next one.
  std::uint64_t held_too_many = 0;
  /// How often a sample waited for more than a second for the callback, because callbacks of other
  /// subscribers of the node were running. The status of the first selection has the count of all selections.
  std::uint64_t long_waits = 0;
  FieldMask mask;              ///< the fields that it asks for at present
  Selection selection{};       ///< these fields, with the parts and the conditions; the rate is below
  double max_rate_hz = 0;      ///< the rate that it asks for at present; 0: all samples
  std::uint64_t requests = 0;  ///< requests for fields and rates that were sent
  std::uint64_t restarts = 0;  ///< connections that were set up anew because nothing arrived
  /// All publishers of the topic, connected or not, and all unmodified DDS writers that were found.
  std::vector<Writer> writers;
};

/// One node. Texts are sentences for people.
struct NodeStatus {
  /// The number of its DDS domain. Nodes of other domains are not seen.
  std::uint32_t domain = 0;
  std::string discovery;  ///< how nodes are found; which settings of the user have no effect, and why
  /// The parts of `discovery` that are warnings: settings of the user that have no effect, and the like.
  std::vector<std::string> discovery_warnings{};
  bool waits_for_network = false;  ///< only the loopback is in use, although other interfaces are wanted
  /// The names of the interfaces by which nodes are found. Empty if the program itself opened the DDS domain;
  /// nodes of the host are then found by the loopback, too.
  std::vector<std::string> discovery_interfaces{};
  std::string udp;  ///< how UDP works here, or why it does not
  /// False: UDP uses plain sockets instead; `udp` says why.
  bool io_uring_in_use = false;
  /// A feature of the system with which UDP takes less processor time.
  struct QuickPath {
    std::string name{};     ///< one of the names below
    std::string why_not{};  ///< why it is not used; empty: it is used
  };
  /// All such features, used or not, on every system: "io_uring", "GSO" and "GRO" (several datagrams are sent
  /// and received in one call), "huge pages" (for large samples).
  std::vector<QuickPath> quick_paths{};
  std::string shm;  ///< how shared memory works here, or why it does not
  /// True: samples can go by shared memory.
  bool shm_ready = false;
  bool lacks_daemon = false;  ///< no sftd is running, and NodeOptions::shm.start_daemon forbids to start one
  /// Datagrams with malformed contents.
  std::uint64_t datagrams_malformed = 0;
  /// Datagrams of publishers to which this node does not subscribe, and answers to datagrams that were not
  /// sent to the one that answers.
  std::uint64_t datagrams_unknown = 0;
  std::uint64_t samples_incomplete = 0;  ///< samples of which a part never came
  /// What UDP dropped to stay within a limit when it sent or received.
  std::uint64_t over_limit = 0;
  std::uint64_t shm_samples_malformed = 0;  ///< samples in shared memory with malformed contents
  std::uint64_t shm_over_limit = 0;         ///< loans and samples that were refused to stay within a limit
  std::uint64_t control_malformed = 0;      ///< endpoints, type descriptions and requests that were refused
  std::uint64_t control_ignored = 0;        ///< endpoints that were refused because the table was full
  /// How often discovery was started anew on an interface because it did not find a node that is there. Nodes
  /// of a process that share discovery have the same count.
  std::uint64_t links_renewed = 0;
};

}  // namespace sft
