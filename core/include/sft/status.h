// The results of publish() and shrink(), and the status of nodes, publishers and subscribers: the results
// of the negotiation, and counts.
//
// A status is a copy of the state at the time of the call of status(); the program owns the copy. Any
// thread may call status(), even in callbacks of SFT. The call locks a separate mutex for a short time and
// makes copies, which takes some microseconds, and longer with many peers. Publishing and receiving do not
// wait for this mutex. NodeSnapshot (snapshot.h) has the status of all publishers and subscribers of a node
// at once.
//
// Counts never decrease. They are read one after the other while samples are sent. So a sample under way
// may already be contained in one count, but not yet in another. When no sample is under way, the counts
// agree exactly.
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

/// Two different definitions of one type. Publishers and subscribers with different definitions never
/// match. "Here" means the program that has called status(). All texts are empty if the definitions were
/// not compared because too many different ones had been announced.
struct TypeMismatch {
  std::string difference;  ///< the first difference: "fields[].offset: uint32 here, uint64 there"
  std::string here;        ///< the whole type here, as IDL
  /// The whole type there; empty, like `difference`, if the other node has not described the type.
  std::string there;
};

/// The result of publishing a message.
enum class PublishStatus : std::uint8_t {
  ok,
  /// Nothing was sent: a string contains a NUL, a bound is exceeded, or the sample is larger than
  /// PublisherOptions::max_sample_bytes. Publisher::why_invalid() names the field.
  invalid,
  no_loan,    ///< nothing was sent: the loan was published already, or moved away
  no_memory,  ///< nothing was sent: no chunk or buffer is free, because readers hold too many samples
  /// A queue was full or no chunk was free, so at least one reader misses this sample and counts it as
  /// lost. With PublisherOptions::max_blocking, publish() has waited for that time, and the reader may have
  /// lost an older sample instead.
  dropped,
  /// Nothing was sent: this process is a copy (fork()) of the process that opened the publisher, and has none
  /// of that process's threads.
  forked,
};
/// Returns a sentence about the status. The text lives as long as the program.
const char* to_string(PublishStatus status);

/// The result of publish(span).
struct PublishedSpan {
  std::size_t published = 0;  ///< the number of messages with the status ok
  /// The status of the first message whose status was not ok, or ok if there is none.
  PublishStatus status = PublishStatus::ok;
};

/// The result of Loan::shrink().
enum class ShrinkStatus : std::uint8_t {
  ok,
  not_reserved,  ///< nothing was changed: the loan named no size for this sequence
  too_long,      ///< nothing was changed: the length is greater than the reserved length
  no_loan,       ///< nothing was changed: the loan was published already, or moved away
};
/// Returns a sentence about the status. The text lives as long as the program.
const char* to_string(ShrinkStatus status);

/// The status of one publisher.
struct PublisherStatus {
  /// One subscriber of the topic, as the publisher serves it.
  /// Larger than usual: each count has a separate named member for users.
  struct Reader {
    std::uint64_t id = 0;       ///< DomainSnapshot::Endpoint::id of the subscriber
    std::string node;           ///< the name of the subscriber's node
    bool served = false;        ///< false: nothing is sent, and `reason` says why
    TransportKind transport{};  ///< valid only while the reader is served
    /// The reason why this transport is used, or why the reader is not served. The text also says so if the
    /// host of the reader does not answer.
    std::string reason{};
    /// If the reader is served by UDP: the readers that share a multicast group with it, or the reason why
    /// it shares no group.
    std::string multicast{};
    bool incompatible_type = false;                   ///< the names or definitions of the types differ
    std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: the two definitions of the type differ
    QosPolicy incompatible_policy = QosPolicy::none;  ///< the first incompatible one; `reason` names all
    bool no_path = false;                             ///< type and QoS are compatible, but no path is allowed
                                                      ///< to both
    /// True: no_path is true, but shared memory may still become available to the publisher or the reader.
    bool no_path_yet = false;
    FieldMask mask{};                    ///< the fields that are sent to the reader
    Selection selection{};               ///< the same fields, with the parts that the reader requests
    double max_rate_hz = 0;              ///< the maximum rate that the reader requests; 0: all samples
    std::uint64_t request_sequence = 0;  ///< the number of the reader's request that is in force

    // The counts of samples since the reader was first served, over all its requests and all its paths.
    // Samples that were queued for the reader when its route changed count as sent.
    std::uint64_t published = 0;  ///< samples while the reader was served: sent + withheld + dropped
    std::uint64_t sent = 0;       ///< samples put into shared memory, passed to the system, or queued for UDP
    std::uint64_t withheld = 0;   ///< samples that were not sent because of conditions or max_rate_hz
    std::uint64_t dropped = 0;    ///< samples not sent: a queue or the memory was full, or the system refused
    std::uint64_t retained = 0;   ///< older samples, which a durable publisher sends first; not counted above
    std::uint64_t diverted = 0;   ///< the part of `sent` that used UDP because shared memory could not take
                                  ///< the samples

    // Counts of bytes in the bodies that were sent over the network or the loopback, without headers. The
    // bytes of a sample in shared memory count neither as sent nor as saved. If several readers of a
    // process request the same fields, bytes that are sent once count for each of these readers.
    std::uint64_t bytes_sent = 0;  ///< the bytes that were sent, see above
    /// The size of the same samples with all fields, minus bytes_sent.
    std::uint64_t bytes_saved = 0;
    friend bool operator==(const Reader&, const Reader&) = default;
  };

  /// The numbers of samples that shared memory could not take, by reason. These samples were sent by UDP to
  /// the readers that may use UDP; the other readers missed them.
  struct Diverted {
    std::uint64_t exhausted = 0;    ///< readers, loans and the history held all chunks of the sample's size
    std::uint64_t too_large = 0;    ///< the sample was larger than the largest chunk
    std::uint64_t unavailable = 0;  ///< the daemon had just ended, or held a lock
    std::uint64_t too_large_bytes = 0;  ///< the size of the largest sample that was too large
    /// The maximum size of a sample that would have fitted into a chunk at that time.
    std::uint64_t chunk_bytes = 0;
    /// Returns the number of all such samples.
    std::uint64_t total() const { return exhausted + too_large + unavailable; }
    friend bool operator==(const Diverted&, const Diverted&) = default;
  };

  std::uint64_t id = 0;         ///< DomainSnapshot::Endpoint::id of the publisher
  std::uint64_t published = 0;  ///< the number of published samples
  /// The bytes of bodies and SFT headers that were sent over the network; each datagram counts once.
  std::uint64_t bytes_sent = 0;
  std::uint64_t bytes_saved = 0;       ///< the sum over all readers, including departed ones
  std::uint64_t deadlines_missed = 0;  ///< periods of the publisher's deadline without a sample
  bool alive = true;                   ///< false: the publisher's liveliness was not asserted in time
  /// The number of samples that at least one transport did not take, and of samples that UDP queued and
  /// could not send later. A sample of the latter kind counts once for each address that missed it.
  std::uint64_t dropped = 0;
  /// The counts of samples that shared memory could not take.
  Diverted diverted{};
  FieldMask mask;  ///< the fields of a sample that are encoded at present
  /// The number of unmodified readers of DDS and ROS 2 that are served at present. These readers are not in
  /// `readers`.
  std::size_t vanilla_readers = 0;
  /// All subscribers of the topic, served or not. A subscriber with several selections has one entry for
  /// each selection.
  std::vector<Reader> readers;
};

/// The status of one subscriber. Counts of samples include all publishers, including departed ones.
struct SubscriberStatus {
  /// One publisher of the topic, as the subscriber receives from it.
  struct Writer {
    std::uint64_t id = 0;  ///< DomainSnapshot::Endpoint::id of the publisher
    /// The name of the publisher's node. An unmodified writer of ROS 2 has that of its node, with a leading
    /// slash. If it is not known, "DDS" and the GUID prefix of the participant.
    std::string node;
    bool matched = false;    ///< false: publisher and subscriber do not match; see `reason`
    bool connected = false;  ///< true: samples of the publisher arrive, by `transport`
    bool alive = true;  ///< false: the lease of the publisher or of its node has expired; `reason` says which
    TransportKind transport{};  ///< valid only while the publisher is connected
    std::string reason{};       ///< the reason for this transport, or for having none; for people
    /// The number of samples of the publisher that are kept until they are taken: SubscriberOptions::depth,
    /// or less if shared memory keeps less.
    std::uint32_t depth = 0;
    bool incompatible_type = false;                   ///< the names or definitions of the types differ
    std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: the two definitions of the type differ
    QosPolicy incompatible_policy = QosPolicy::none;  ///< the first incompatible one; `reason` names all
    bool no_path = false;                             ///< type and QoS are compatible, but no path is allowed
                                                      ///< to both
    /// True: no_path is true, but shared memory may still become available to the publisher or the
    /// subscriber.
    bool no_path_yet = false;
    std::uint64_t received = 0;  ///< samples that were taken or passed to the callback
    std::uint64_t lost = 0;      ///< samples that should have arrived, and did not
    std::uint64_t withheld = 0;  ///< samples that conditions or max_rate_hz have withheld
    std::uint64_t expired = 0;   ///< samples that were not delivered because their lifespan was over
    /// The number of periods of the subscriber's deadline without samples of this publisher.
    std::uint64_t deadlines_missed = 0;
    /// The number of times that the connection was set up anew because nothing arrived although the
    /// publisher sent samples.
    std::uint64_t restarts = 0;
  };

  std::uint64_t received = 0;  ///< samples that were taken or passed to the callback
  /// Samples that should have arrived, and did not. Samples of departed publishers count if they were not
  /// taken in time.
  std::uint64_t lost = 0;
  std::uint64_t withheld = 0;  ///< samples that conditions or max_rate_hz have withheld
  std::uint64_t expired = 0;   ///< samples that were not delivered because their lifespan was over
  /// The number of samples that arrived and were discarded, because they were malformed or the queue was
  /// full. Samples that were discarded because of a full queue also count as lost, once a later sample is
  /// taken.
  std::uint64_t discarded = 0;
  /// The number of times that the next sample of a publisher could not be taken because the program held
  /// SubscriberOptions::max_held samples of that publisher.
  std::uint64_t held_too_many = 0;
  /// The number of samples that waited for the callback for more than a second because callbacks of other
  /// subscribers of the node were running. The status of the first selection contains the count for all
  /// selections.
  std::uint64_t long_waits = 0;
  FieldMask mask;              ///< the fields that the subscriber requests at present
  Selection selection{};       ///< the same fields, with their parts and the conditions; the rate is in
                               ///< `max_rate_hz`
  double max_rate_hz = 0;      ///< the maximum rate that the subscriber requests at present; 0: all samples
  std::uint64_t requests = 0;  ///< the number of requests for fields and rates that were sent
  std::uint64_t restarts = 0;  ///< the number of connections that were set up anew because nothing arrived
  /// All publishers of the topic, connected or not, and all unmodified DDS writers that were found.
  std::vector<Writer> writers;
};

/// The status of one node. Texts are sentences for people.
struct NodeStatus {
  /// The number of the DDS domain of the node. Nodes of other domains are not found.
  std::uint32_t domain = 0;
  /// The way in which nodes are found, and the settings of the user that have no effect, with the reasons.
  std::string discovery;
  /// The parts of `discovery` that are warnings: settings of the user that have no effect, and the like.
  std::vector<std::string> discovery_warnings{};
  bool waits_for_network = false;  ///< only the loopback is in use, although other interfaces are wanted
  /// The names of the interfaces by which nodes are found.
  std::vector<std::string> discovery_interfaces{};
  std::string udp;  ///< how UDP works here, or the reason why it does not
  /// False: UDP uses plain sockets instead; `udp` says why.
  bool io_uring_in_use = false;
  /// A feature of the system that reduces the processor time of UDP.
  struct QuickPath {
    std::string name{};     ///< one of the names in the comment on quick_paths
    std::string why_not{};  ///< the reason why the feature is not used; empty: it is used
  };
  /// All such features, whether they are used or not, on every system: "io_uring", "GSO" and "GRO" (several
  /// datagrams are sent and received in one call), "huge pages" (for large samples).
  std::vector<QuickPath> quick_paths{};
  std::string shm;  ///< how shared memory works here, or the reason why it does not
  /// True: samples can be sent by shared memory.
  bool shm_ready = false;
  /// True: no sftd is running, and NodeOptions::shm.start_daemon does not allow the node to start one.
  bool lacks_daemon = false;
  /// The number of datagrams with malformed contents.
  std::uint64_t datagrams_malformed = 0;
  /// The number of datagrams of publishers to which this node does not subscribe, and of answers from hosts
  /// to which the datagrams in question were not sent.
  std::uint64_t datagrams_unknown = 0;
  std::uint64_t samples_incomplete = 0;  ///< the number of samples of which a part never arrived
  /// The number of samples and datagrams that UDP dropped to stay within a limit, while sending or
  /// receiving.
  std::uint64_t over_limit = 0;
  std::uint64_t shm_samples_malformed = 0;  ///< samples in shared memory with malformed contents
  std::uint64_t shm_over_limit = 0;         ///< loans and samples refused to stay within a limit
  std::uint64_t control_malformed = 0;      ///< endpoints, descriptions and requests that were refused
  /// The number of announcements that were not used, because a process has announced more than one may.
  std::uint64_t control_ignored = 0;
  /// The number of times that discovery was started anew on an interface because it did not find an existing
  /// node. Nodes of a process that share discovery have the same count.
  std::uint64_t links_renewed = 0;
};

}  // namespace sft
