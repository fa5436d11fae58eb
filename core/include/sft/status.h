// Snapshots of what was negotiated and what was counted.
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

/// Two definitions of one type, which never match. "Here" is the program whose status this is.
struct TypeMismatch {
  std::string difference;  ///< the first one: "fields[].offset: uint32 here, uint64 there"
  std::string here;        ///< the whole types as IDL
  std::string there;       ///< empty, as is the difference, if the other side does not describe its type
};

/// One reader as its publisher serves it.
struct ReaderStatus {
  std::uint64_t id = 0;
  std::string node;
  bool served = false;  ///< false: `reason` says why nothing is sent
  TransportKind transport{};
  std::string reason{};  ///< for the transport, or for not being served
  bool incompatible_type = false;
  std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions of one type
  QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
  FieldMask mask{};
  double max_rate_hz = 0;              ///< that it asks for; 0: all samples
  std::uint64_t withheld = 0;          ///< samples that were not sent to it for that
  std::uint64_t request_sequence = 0;  ///< of the STR in force
  friend bool operator==(const ReaderStatus&, const ReaderStatus&) = default;
};

struct PublisherStatus {
  std::uint64_t published = 0;   ///< samples
  std::uint64_t bytes_sent = 0;  ///< payload and SFT headers over the network
  std::uint64_t deadlines_missed = 0;
  bool alive = true;  ///< or it did not assert its liveliness in time
  /// Samples that could not be handed to some transport; and those that UDP queued and then could not send,
  /// once for each address that missed one.
  std::uint64_t dropped = 0;
  std::vector<ReaderStatus> readers;  ///< all of the topic, served or not
};

/// One writer as its subscriber hears it.
struct WriterStatus {
  std::uint64_t id = 0;
  std::string node;
  bool matched = false;  ///< false: `reason` says why
  bool alive = true;     ///< false: its lease or its node's is over, which `reason` says
  TransportKind transport{};
  std::string reason{};
  bool incompatible_type = false;
  std::shared_ptr<const TypeMismatch> mismatch{};   ///< not null: two definitions of one type
  QosPolicy incompatible_policy = QosPolicy::none;  ///< the first that does not fit; `reason` names all
  std::uint64_t received = 0;
  std::uint64_t lost = 0;      ///< samples that should have come
  std::uint64_t withheld = 0;  ///< samples that did not come, or were skipped, for max_rate_hz
  std::uint64_t expired = 0;   ///< samples that were not delivered because their lifespan was over
  std::uint64_t deadlines_missed = 0;
};

struct SubscriberStatus {
  std::uint64_t received = 0;  ///< samples taken or given to the callback
  std::uint64_t lost = 0;      ///< with what writers left behind and was not taken in time
  std::uint64_t withheld = 0;  ///< for max_rate_hz
  std::uint64_t expired = 0;   ///< with their lifespan
  FieldMask mask;              ///< what is asked for at present
  std::uint64_t requests = 0;  ///< STRs sent
  std::vector<WriterStatus> writers;
};

struct NodeStatus {
  std::string discovery;  ///< how nodes are found here, and which of the user's settings do not hold, and why
  std::string udp;        ///< how UDP works here, or why it does not
  std::string shm;
  bool shm_ready = false;
  std::uint64_t datagrams_malformed = 0;
  std::uint64_t datagrams_unknown = 0;  ///< of writers that nobody here reads
  std::uint64_t samples_incomplete = 0;
  std::uint64_t over_limit = 0;
  std::uint64_t control_malformed = 0;  ///< endpoints, type descriptions and requests that were refused
  std::uint64_t control_ignored = 0;    ///< those beyond the limits of the table of endpoints
};

}  // namespace sft
