// The results of publish() and shrink(), and the status of nodes, publishers and subscribers: what was
// negotiated and what was counted.
//
// A status is a copy of what was true when status() was called; the program owns it. Any thread may call
// status(), also in callbacks of SFT. The call takes a short lock of its own and copies, which takes some
// microseconds, more with many peers; neither publishing nor receiving waits for it. NodeSnapshot
// (snapshot.h) has the status of all publishers and subscribers of a node at once.
//
// Counts only grow. They are read one after the other while samples are sent, so that a sample on its way may
// be in one count already and not yet in another; when no sample is on its way they agree exactly.
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

/// The path of samples: shared memory within a host, or UDP.
enum class TransportKind : std::uint8_t { shm, udp };
constexpr const char* to_string(TransportKind kind) { return kind == TransportKind::shm ? "shm" : "udp"; }

/// Two definitions of one type; their publishers and subscribers never match. "Here" is the program whose
/// status this is. All texts are empty if so many other definitions were announced that this one was not
/// compared.
struct TypeMismatch {
  std::string difference;  ///< the first one: "fields[].offset: uint32 here, uint64 there"
  std::string here;        ///< the whole types as IDL
  std::string there;       ///< empty, as is the difference, if the other side does not describe its type
};

/// The result of publishing a message.
enum class PublishStatus : std::uint8_t {
  ok,
  /// Nothing was sent: a string has a NUL in it, a bound is exceeded, or the sample is larger than
  /// PublisherOptions::max_sample_bytes. Publisher::why_invalid() names the field.
  invalid,
  no_loan,    ///< nothing was sent: the loan was published already, or moved away
  no_memory,  ///< nothing was sent: no chunk or buffer is free, because readers hold too many samples
  /// A queue was full or no chunk was free, so that at least one reader misses this sample, and counts it.
  /// With PublisherOptions::max_blocking that time was over, and the reader may miss an older sample instead.
  dropped,
  /// Nothing was sent: this process is a copy (fork()) of the one that opened the publisher, which has none
  /// of its threads.
  forked,
};
/// A sentence about the status; lives as long as the program.
const char* to_string(PublishStatus status);

/// The result of publish(span).
struct PublishedSpan {
  std::size_t published = 0;                 ///< the number of messages with the status ok
  PublishStatus status = PublishStatus::ok;  ///< of the first message that has another one, otherwise ok
};

/// The result of Loan::shrink().
enum class ShrinkStatus : std::uint8_t {
  ok,
  not_reserved,  ///< nothing: the loan named no size for this sequence
  too_long,      ///< nothing: the length is more than what was reserved
  no_loan,       ///< nothing: the loan was published already, or moved away
};
/// A sentence about the status; lives as long as the program.
const char* to_string(ShrinkStatus status);

/// One publisher.
struct PublisherStatus {
  /// One subscriber of the topic, as the publisher serves it.
  /// Larger than usual: it is a record, whose counters have names of their own for users.
  struct Reader {
    std::uint64_t id = 0;       ///< DomainSnapshot::Endpoint::id of the subscriber
    std::string node;           ///< the name of its node
    bool served = false;        ///< false: `reason` says why nothing is sent
    TransportKind transport{};  ///< means something only while it is served
    /// Why this transport is used, or why the reader is not served; says also if its host does not answer.
    std::string reason{};
    /// If it is served by UDP: with whom it shares a multicast group, or why it shares none.
    std::string multicast{};
    bool incompatible_type = false;                   ///< the names or definitions of the types differ
    std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions of one type
    QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
    bool no_path = false;                             ///< all fits, but no path is allowed to both
    bool no_path_yet = false;  ///< no_path, and shared memory may still come up on this side or the other
    FieldMask mask{};          ///< the fields that it is sent
    Selection selection{};     ///< these fields, with the parts that it asks for
    double max_rate_hz = 0;    ///< the rate that it asks for; 0: all samples
    std::uint64_t request_sequence = 0;  ///< the number of its request that is in force

    // Samples since the reader was first served, over all its requests and all its paths. Samples that were
    // queued for it when its route changed count as sent.
    std::uint64_t published = 0;  ///< while it was served: sent + withheld + dropped
    std::uint64_t sent = 0;       ///< put into shared memory, given to the system, or queued for that
    std::uint64_t withheld = 0;   ///< not sent, because of conditions or max_rate_hz
    std::uint64_t dropped = 0;    ///< not sent: a queue or the memory was full, or the system refused
    std::uint64_t retained = 0;   ///< older ones that a durable publisher sent first; not in the counts above
    std::uint64_t diverted = 0;   ///< a part of `sent`: sent by UDP because shared memory could not take them

    // Bytes of the bodies that went over the network or the loopback, without headers. A sample in shared
    // memory counts neither as sent nor as saved. If several readers of a process ask for the same fields,
    // bytes that travel once count for each of these readers.
    std::uint64_t bytes_sent = 0;  ///< see above
    /// The size of the same samples with all fields, less bytes_sent.
    std::uint64_t bytes_saved = 0;
    friend bool operator==(const Reader&, const Reader&) = default;
  };

  /// The number of samples that shared memory could not take, by reason. They went by UDP to the readers that
  /// may use UDP; the other readers missed them.
  struct Diverted {
    std::uint64_t exhausted = 0;    ///< readers, loans and the history held all chunks of that size
    std::uint64_t too_large = 0;    ///< the sample was larger than the largest chunk
    std::uint64_t unavailable = 0;  ///< the daemon had just ended, or held a lock
    /// Samples, for whatever reason.
    std::uint64_t total() const { return exhausted + too_large + unavailable; }
    friend bool operator==(const Diverted&, const Diverted&) = default;
  };

  std::uint64_t id = 0;                ///< DomainSnapshot::Endpoint::id of the publisher
  std::uint64_t published = 0;         ///< the number of samples
  std::uint64_t bytes_sent = 0;        ///< bodies and SFT headers over the network, each datagram once
  std::uint64_t bytes_saved = 0;       ///< for all readers, also those that are gone
  std::uint64_t deadlines_missed = 0;  ///< periods of its own deadline without a sample
  bool alive = true;                   ///< false: it did not assert its liveliness in time
  /// Samples that some transport did not take, and those that UDP queued and then could not send; the latter
  /// count once for each address that missed one.
  std::uint64_t dropped = 0;
  /// Samples that shared memory could not take.
  Diverted diverted{};
  FieldMask mask;  ///< the fields of a sample that are encoded at present
  /// Readers of DDS and ROS 2, which know nothing of SFT and are not in `readers`, that are served at
  /// present.
  std::size_t vanilla_readers = 0;
  /// All subscribers of the topic, served or not. A subscriber with several selections is here once for each.
  std::vector<Reader> readers;
};

/// One subscriber. Sample counts are over all publishers, also those that are gone.
struct SubscriberStatus {
  /// One publisher of the topic, as the subscriber receives from it.
  struct Writer {
    std::uint64_t id = 0;       ///< DomainSnapshot::Endpoint::id of the publisher
    std::string node;           ///< the name of its node
    bool matched = false;       ///< false: `reason` says why
    bool connected = false;     ///< its samples come, by `transport`
    bool alive = true;          ///< false: its lease or that of its node is over; `reason` says which
    TransportKind transport{};  ///< means something only while it is connected
    std::string reason{};       ///< for the transport, or for there being none; for people
    /// The number of its samples that are kept until they are taken: SubscriberOptions::depth, or as many as
    /// shared memory keeps.
    std::uint32_t depth = 0;
    bool incompatible_type = false;                   ///< the names or definitions of the types differ
    std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions of one type
    QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
    bool no_path = false;                             ///< all fits, but no path is allowed to both
    bool no_path_yet = false;    ///< no_path, and shared memory may still come up on this side or the other
    std::uint64_t received = 0;  ///< samples that were taken or given to the callback
    std::uint64_t lost = 0;      ///< samples that should have come, and did not
    std::uint64_t withheld = 0;  ///< samples that conditions or max_rate_hz have withheld
    std::uint64_t expired = 0;   ///< samples that were not delivered because their lifespan was over
    std::uint64_t deadlines_missed = 0;  ///< periods of the subscriber's deadline without a sample of it
    /// How often the connection was set up anew because the publisher sent and nothing arrived.
    std::uint64_t restarts = 0;
  };

  std::uint64_t received = 0;  ///< samples that were taken or given to the callback
  std::uint64_t lost = 0;      ///< also those of publishers that are gone that were not taken in time
  std::uint64_t withheld = 0;  ///< samples that conditions or max_rate_hz have withheld
  std::uint64_t expired = 0;   ///< samples that were not delivered because their lifespan was over
  /// Samples that arrived and were thrown away: malformed ones, and those that a full queue pushed out. The
  /// latter count as lost, too, once a later sample is taken.
  std::uint64_t discarded = 0;
  /// How often it held SubscriberOptions::max_held samples of a publisher and could not take the next one.
  std::uint64_t held_too_many = 0;
  /// How often a sample waited for more than a second for the callback, because callbacks of other
  /// subscribers of the node were running. Of the first selection, for all.
  std::uint64_t long_waits = 0;
  FieldMask mask;              ///< the fields that it asks for at present
  Selection selection{};       ///< these fields, with the parts and the conditions; the rate is below
  double max_rate_hz = 0;      ///< the rate that it asks for at present; 0: all samples
  std::uint64_t requests = 0;  ///< requests for fields and rates that were sent
  std::uint64_t restarts = 0;  ///< connections that were set up anew because nothing arrived
  /// All publishers of the topic, heard or not.
  std::vector<Writer> writers;
};

/// One node. Texts are sentences for people.
struct NodeStatus {
  /// The number of its DDS domain. Nodes of other domains are not seen.
  std::uint32_t domain = 0;
  std::string discovery;  ///< how nodes are found, and which settings of the user have no effect, and why
  /// Parts of `discovery`: settings of the user that have no effect, and other warnings of the log.
  std::vector<std::string> discovery_warnings{};
  bool waits_for_network = false;  ///< only the loopback is in use, although other interfaces are wanted
  /// The names of the interfaces by which nodes are found; empty if the program itself opened the DDS domain,
  /// though nodes of the host are then found by the loopback, too.
  std::vector<std::string> discovery_interfaces{};
  std::string udp;  ///< how UDP works here, or why it does not
  /// False: plain sockets; `udp` says why.
  bool io_uring_in_use = false;
  /// A way of the system by which UDP takes less processor time.
  struct QuickPath {
    std::string name{};     ///< one of those below
    std::string why_not{};  ///< empty: it is used
  };
  /// All of them, used or not, on every system: "io_uring", "GSO" and "GRO" (several datagrams in one call,
  /// sent and received), "huge pages" (of large samples).
  std::vector<QuickPath> quick_paths{};
  std::string shm;  ///< how shared memory works here, or why it does not
  /// Samples can go by shared memory.
  bool shm_ready = false;
  bool lacks_daemon = false;  ///< no sftd is running, and NodeOptions::shm.start_daemon forbids to start one
  /// Datagrams whose bytes are not what they claim to be.
  std::uint64_t datagrams_malformed = 0;
  /// Datagrams of publishers that nobody here subscribes to, and answers that do not belong to anything that
  /// was sent to their sender.
  std::uint64_t datagrams_unknown = 0;
  std::uint64_t samples_incomplete = 0;     ///< samples of which a part never came
  std::uint64_t over_limit = 0;             ///< what UDP dropped, sent or received, to stay within a limit
  std::uint64_t shm_samples_malformed = 0;  ///< samples in shared memory that are not what they claim to be
  std::uint64_t shm_over_limit = 0;         ///< loans and samples that were refused to stay within a limit
  std::uint64_t control_malformed = 0;      ///< endpoints, type descriptions and requests that were refused
  std::uint64_t control_ignored = 0;        ///< those beyond the limits of the table of endpoints
  /// How often discovery was begun anew on one interface because a node that is there was not heard by it.
  /// The nodes of a process that share discovery count the same.
  std::uint64_t links_renewed = 0;
};

}  // namespace sft
