// The values that the control topics transport, in the form in which the core uses them: checked, and without
// types of Cyclone DDS.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/names/qos.h"
#include "core/seam/transport.h"
#include "sft/domain.h"

namespace sft::core {

/// Bounds of the bodies of records and reports (record_body.h): the words of a mask, and the bytes of
/// Request::parts.
inline constexpr std::size_t mask_words_max = 64;
inline constexpr std::size_t wants_bytes_max = 2304;
/// The maximum number of fields of a type. A word of a mask has 64 bits.
inline constexpr std::size_t leaves_max = 64 * mask_words_max;
inline constexpr std::size_t writers_per_reader_max = 1024;
inline constexpr std::size_t addresses_max = 16;
inline constexpr std::size_t living_max = 1024;
inline constexpr std::size_t progress_max = 64;
inline constexpr std::size_t accounts_max = 32;
inline constexpr std::size_t type_description_bytes_max = 65'536;

/// The greatest sequence of an accepted request. Later requests can still have greater sequences.
inline constexpr std::uint64_t request_sequence_max = std::uint64_t{1} << 63;

using NodeId = std::uint64_t;  ///< random, new each time that a node is opened; never 0

enum class Role : std::uint8_t { writer, reader };

constexpr Role other(Role role) { return role == Role::writer ? Role::reader : Role::writer; }

/// Returns true if the list, by which a request names writers, contains the id.
inline bool holds(const std::vector<EndpointId>& ids, EndpointId id) {
  return std::ranges::find(ids, id) != ids.end();
}

/// A selective transmission request (STR).
struct Request {
  EndpointId reader = 0;
  std::uint64_t sequence = 0;
  std::vector<std::uint64_t> mask_words;
  std::uint32_t min_period_us = 0;  ///< the minimum time between two samples, in microseconds; 0: all samples
  /// The encoded selection (Selection::to_bytes()) without its maximum rate, if it has parts of fields or
  /// conditions; empty: the reader requests whole fields of all samples. The receiving process may not know
  /// the type, so the bytes are decoded only when the reader is served.
  std::vector<std::byte> parts{};
  std::vector<EndpointId> listening;  ///< writers whose datagrams the reader accepts
  std::vector<EndpointId> attached;   ///< writers to whose shared memory the reader is attached
  /// The durable writers whose first retained sample for this reader alone has arrived.
  std::vector<EndpointId> begun;
  friend bool operator==(const Request&, const Request&) = default;
};

/// The numbers of samples that one writer has sent.
struct Progress {
  EndpointId writer = 0;
  std::uint64_t samples = 0;  ///< the number of samples that were sent to the writer's readers so far
  std::uint64_t bytes = 0;    ///< the bytes of their bodies that were sent over the network; a body counts
                              ///< once for each reader
  friend bool operator==(const Progress&, const Progress&) = default;
};

/// A writer and a reader of one topic.
struct PairId {
  EndpointId writer = 0;
  EndpointId reader = 0;
  friend auto operator<=>(const PairId&, const PairId&) = default;
};

/// Identifies an account. Each side of a pair has its own account of the pair.
struct AccountId {
  PairId pair{};
  Role said_by{};  ///< the side of the pair whose node has counted
  friend auto operator<=>(const AccountId&, const AccountId&) = default;
};

/// The counts of one side of a pair. The members that only the other side counts are empty.
struct Account {
  AccountId id{};
  DomainSnapshot::Sent by_writer{};  ///< without an age
  DomainSnapshot::Received by_reader{};
  friend bool operator==(const Account&, const Account&) = default;
};

/// A request of a node for information that records do not contain.
struct Inquiry {
  std::string topic{};  ///< the topic; empty: all topics
  /// True: asks for the accounts of pairs. False: asks for the progress of writers, and for the ids of
  /// living writers.
  bool wants_accounts = false;
  friend auto operator<=>(const Inquiry&, const Inquiry&) = default;
};

/// A report of a node about its own endpoints, for the nodes that inquire.
struct NodeReport {
  std::vector<EndpointId> living{};  ///< writers that are alive, although they send too few samples to show
                                     ///< it
  std::vector<Progress> progress{};
  std::vector<Account> accounts{};

  bool empty() const { return living.empty() && progress.empty() && accounts.empty(); }
  friend bool operator==(const NodeReport&, const NodeReport&) = default;
};

/// A publisher or subscriber, of this node or of another one. The fields are those of sft_control.idl.
struct Endpoint {
  EndpointId id = 0;
  Role role{};
  NodeId node_id = 0;
  std::string node;
  std::string topic;
  std::string given_topic;  ///< the topic name that the endpoint's program uses; empty if it equals `topic`
  std::string type_name;
  std::uint64_t type_hash = 0;
  /// The encoded fields of the type; may be empty (described_type.h).
  std::vector<std::byte> type_description;
  HostToken host;
  /// The reason why the endpoint's node has no shared memory. Empty if the node has shared memory, or may
  /// still get it.
  std::string memory_failure;
  std::uint64_t network = 0;
  bool may_use_memory = false;
  bool may_use_network = false;
  std::vector<UdpAddress> addresses;
  DoorbellAddress doorbell;
  std::uint64_t max_sample_bytes = 0;
  bool waits = false;
  Qos qos;
  Request request;
  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

/// Returns the version of the control topics. Control samples of another version are refused.
std::uint32_t control_protocol_version();

}  // namespace sft::core
