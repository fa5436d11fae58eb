// What was negotiated and what was counted, as it is when asked for. status() may be called by any thread,
// callbacks of SFT included. It takes a short lock of its own and copies: some microseconds, more with many
// peers, and nothing waits for it, who publishes least of all. For all of a node at once there is snapshot.h.
//
// Counts only grow. They are read one after the other while samples go on, so that a sample under way may be
// in one count already and not yet in another; when nothing is under way they agree exactly.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sft/qos.h"
#include "sft/typesupport/field_mask.h"

namespace sft {

enum class TransportKind : std::uint8_t { shm, udp };
constexpr const char* to_string(TransportKind kind) { return kind == TransportKind::shm ? "shm" : "udp"; }

/// Two definitions of one type, which never match. "Here" is the program whose status this is. All are empty
/// where so many other definitions were announced that this one was not compared.
struct TypeMismatch {
  std::string difference;  ///< the first one: "fields[].offset: uint32 here, uint64 there"
  std::string here;        ///< the whole types as IDL
  std::string there;       ///< empty, as is the difference, if the other side does not describe its type
};

/// One reader as its publisher serves it.
struct ReaderStatus {
  std::uint64_t id = 0;       ///< EndpointInfo::id of the subscriber
  std::string node;           ///< the name of its node
  bool served = false;        ///< false: `reason` says why nothing is sent
  TransportKind transport{};  ///< means something only while it is served
  /// For the transport, or for not being served; and that its host does not answer, where that is so.
  std::string reason{};
  /// Of one that is served by UDP: with whom it shares a multicast group, or why with nobody.
  std::string multicast{};
  bool incompatible_type = false;                   ///< the names or definitions of the types differ
  std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions of one type
  QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
  bool no_path = false;                             ///< fits, but not the ways that both may use
  bool no_path_yet = false;            ///< the same, while shared memory may still come up here or there
  FieldMask mask{};                    ///< of the fields that it is sent
  double max_rate_hz = 0;              ///< that it asks for; 0: all samples
  std::uint64_t request_sequence = 0;  ///< of the STR in force

  // Samples, since it was first served, over all that it asked for and all paths it had. What was queued for
  // it when its route changed counts as sent.
  std::uint64_t published = 0;  ///< while it was served: sent + withheld + dropped
  std::uint64_t sent = 0;       ///< put into shared memory, handed to the system, or queued to be
  std::uint64_t withheld = 0;   ///< not sent to it for max_rate_hz
  std::uint64_t dropped = 0;    ///< a queue or the memory was full, or the system refused
  std::uint64_t retained = 0;   ///< older ones, sent first, of a durable publisher; not in the counts above
  std::uint64_t diverted = 0;   ///< of `sent`: by UDP, since shared memory could not take them

  // Bytes over the network, loopback too, of the bodies of what was sent, without headers; in shared memory
  // nothing is sent and nothing counts as saved. Where several readers of a process ask for the same, what
  // travels once counts for each of them.
  std::uint64_t bytes_sent = 0;  ///< see above
  /// Of the same samples: what whole bodies would have been, less bytes_sent. A sample that was not encoded
  /// whole is taken to have been as large as the last one measured, at most 10 ms before.
  std::uint64_t bytes_saved = 0;
  friend bool operator==(const ReaderStatus&, const ReaderStatus&) = default;
};

/// Samples that shared memory could not take, by reason. They went by UDP to those of its readers that may
/// use that; the others missed them.
struct Diverted {
  std::uint64_t exhausted = 0;  ///< no chunk of its size was free: readers, loans, the history hold them all
  std::uint64_t too_large = 0;  ///< larger than the largest chunk
  std::uint64_t unavailable = 0;  ///< the daemon was gone, which was about to be noticed, or held a lock
  std::uint64_t total() const {
    return exhausted + too_large + unavailable;
  }  ///< samples, for whatever reason
  friend bool operator==(const Diverted&, const Diverted&) = default;
};

/// Counts of a publisher since it was opened, and its readers. A copy.
struct PublisherStatus {
  std::uint64_t published = 0;         ///< samples
  std::uint64_t bytes_sent = 0;        ///< bodies and SFT headers over the network, each datagram once
  std::uint64_t bytes_saved = 0;       ///< of all readers, with those that are gone
  std::uint64_t deadlines_missed = 0;  ///< periods of its own deadline without a sample
  bool alive = true;                   ///< or it did not assert its liveliness in time
  /// Samples that could not be handed to some transport; and those that UDP queued and then could not send,
  /// once for each address that missed one.
  std::uint64_t dropped = 0;
  /// Samples that shared memory could not take.
  Diverted diverted{};
  FieldMask mask;                     ///< what is encoded of a sample at present
  std::vector<ReaderStatus> readers;  ///< all of the topic, served or not
};

/// One writer as its subscriber hears it.
struct WriterStatus {
  std::uint64_t id = 0;       ///< EndpointInfo::id of the publisher
  std::string node;           ///< the name of its node
  bool matched = false;       ///< false: `reason` says why
  bool connected = false;     ///< what it sends comes, by `transport`
  bool alive = true;          ///< false: its lease or its node's is over, which `reason` says
  TransportKind transport{};  ///< means something only while it is connected
  std::string reason{};       ///< for the transport, or for there being none; for people
  /// Samples of it that are kept until they are taken: SubscriberOptions::depth, or as many as shared memory
  /// keeps.
  std::uint32_t depth = 0;
  bool incompatible_type = false;                   ///< the names or definitions of the types differ
  std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions of one type
  QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
  bool no_path = false;                             ///< fits, but not the ways that both may use
  bool no_path_yet = false;            ///< the same, while shared memory may still come up here or there
  std::uint64_t received = 0;          ///< samples taken or given to the callback
  std::uint64_t lost = 0;              ///< samples that should have come
  std::uint64_t withheld = 0;          ///< samples that did not come, or were skipped, for max_rate_hz
  std::uint64_t expired = 0;           ///< samples that were not delivered because their lifespan was over
  std::uint64_t deadlines_missed = 0;  ///< periods of the subscriber's deadline without a sample of it
  /// Times that the connection was set up anew, since it sent and nothing arrived.
  std::uint64_t restarts = 0;
};

/// Counts of a subscriber since it was opened, and its publishers. A copy.
struct SubscriberStatus {
  std::uint64_t received = 0;  ///< samples taken or given to the callback
  std::uint64_t lost = 0;      ///< with what writers left behind and was not taken in time
  std::uint64_t withheld = 0;  ///< for max_rate_hz
  std::uint64_t expired = 0;   ///< with their lifespan
  /// That arrived and were thrown away: pushed out of a full queue, which counts as lost once a later one is
  /// taken, or malformed.
  std::uint64_t discarded = 0;
  /// Times that it held SubscriberOptions::max_held samples of a publisher and could not take the next.
  std::uint64_t held_too_many = 0;
  FieldMask mask;              ///< what is asked for at present
  double max_rate_hz = 0;      ///< likewise; 0: all samples
  std::uint64_t requests = 0;  ///< STRs sent
  std::uint64_t restarts = 0;  ///< of connections by which nothing arrived
  /// All publishers of the topic, heard or not.
  std::vector<WriterStatus> writers;
};

/// How discovery and the transports work for a node, and what they have refused since it was opened.
struct NodeStatus {
  std::string discovery;  ///< how nodes are found here, and which of the user's settings do not hold, and why
  /// Parts of that: what of the user's settings does not hold, and what else the log has as a warning.
  std::vector<std::string> discovery_warnings{};
  bool waits_for_network = false;  ///< nothing but the loopback is in use, although more is wanted
  /// The names of those that nodes are found by; empty where the program itself has opened the DDS domain.
  std::vector<std::string> discovery_interfaces{};
  std::string udp;  ///< how UDP works here, or why it does not
  /// False: plain sockets; `udp` says why.
  bool io_uring_in_use = false;
  /// How shared memory works here, or why it does not and what to do.
  std::string shm;
  /// Samples can go by shared memory.
  bool shm_ready = false;
  bool lacks_daemon = false;  ///< no sftd is running, and NodeOptions::shm.start_daemon forbids to start one
  /// Datagrams whose bytes are not what they claim to be.
  std::uint64_t datagrams_malformed = 0;
  /// Of writers that nobody here reads; and answers that are of nothing that was sent, or come from others
  /// than it was sent to.
  std::uint64_t datagrams_unknown = 0;
  std::uint64_t samples_incomplete = 0;     ///< of which a part never came
  std::uint64_t over_limit = 0;             ///< by UDP: sent or received, and dropped to stay within a limit
  std::uint64_t shm_samples_malformed = 0;  ///< that are not what they claim to be
  std::uint64_t shm_over_limit = 0;         ///< no memory lent, nothing taken or sent, to stay within a limit
  std::uint64_t control_malformed = 0;      ///< endpoints, type descriptions and requests that were refused
  std::uint64_t control_ignored = 0;        ///< those beyond the limits of the table of endpoints
  /// Times that discovery was begun anew on one interface, since a node that is there was not heard by it.
  std::uint64_t links_renewed = 0;
};

}  // namespace sft
