// The figures of a run. The demo measures them; the table, the summary and a JSON file show them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/demo/roles/protocol.h"

namespace sft::demo {

struct SubscriberFigures : Reception {
  std::string name;
  std::string host;
  double max_rate_hz = 0;  ///< 0: all samples
  bool recorded = false;
  std::uint64_t withheld = 0;           ///< samples that were not sent, since it asks for a lower rate
  double payload_bytes = 0;             ///< sum over all received samples
  std::optional<double> wire_bytes;     ///< their bytes on the wire, learning included; empty: not measured
  double full_bytes_per_sample = 0;     ///< encapsulation and body of the whole message
  double payload_bytes_per_sample = 0;  ///< 0 in shared memory
  std::optional<double> wire_bytes_per_sample;  ///< with link-layer headers; empty: not measured
  std::optional<double> learning_bytes;         ///< bytes on the wire until the recorded mask had narrowed

  bool in_shared_memory() const { return transport == "shm"; }
  /// Returns the share of the bytes of all whole messages that was not sent to the subscriber. The payload
  /// counts if the wire was not measured.
  double saved() const;
  /// Returns the bytes that saved() compares with those of the whole message.
  double sent_bytes_per_sample() const { return wire_bytes_per_sample.value_or(payload_bytes_per_sample); }
};

/// Sums over all subscribers that are not served in shared memory.
struct Carried {
  double bytes = 0;        ///< bytes that were sent
  double whole_bytes = 0;  ///< bytes of all whole messages to all of them
  double saved() const { return whole_bytes > 0 ? 1 - bytes / whole_bytes : 0; }
};

struct RunFigures {
  double hz = 0;
  std::uint64_t samples = 0;
  std::uint64_t dropped = 0;  ///< samples that missed a subscriber, since a queue was full
  unsigned hosts = 0;
  std::vector<SubscriberFigures> subscribers;

  bool real_hosts() const { return hosts > 1; }
  std::uint64_t lost() const;
  Carried carried() const;
};

nlohmann::ordered_json to_json(const RunFigures& figures);

/// Returns "header, width", "all", or "all but height, 1 Hz".
std::string format_request(const SubscriberFigures& subscriber);

}  // namespace sft::demo
