// What a run measured: filled by the demo, shown by the table and the summary, written as JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace sft::demo {

struct SubscriberFigures {
  std::string name;
  std::string host;
  double max_rate_hz = 0;                 ///< asked for; 0: all samples
  std::string transport;                  ///< "shm" or "udp"
  std::string reason;                     ///< for the transport
  std::vector<std::string> fields;        ///< asked for
  std::vector<std::string> other_fields;  ///< the rest
  bool recorded = false;
  std::uint64_t received = 0;
  std::uint64_t lost = 0;
  std::uint64_t incomplete = 0;         ///< of the lost ones: some of it came
  std::uint64_t withheld = 0;           ///< not sent, since it asks for a lower rate
  double payload_bytes = 0;             ///< of all that was received
  std::optional<double> wire_bytes;     ///< likewise on the wire, learning included; empty: not measured
  double full_bytes_per_sample = 0;     ///< encapsulation and body of the whole message
  double payload_bytes_per_sample = 0;  ///< of what was received; in shared memory, of what can be read
  std::optional<double> wire_bytes_per_sample;  ///< link layer included; empty where it cannot be measured
  std::optional<double> learning_bytes;         ///< on the wire, before the recorded mask had narrowed
  std::optional<double> latency_p50_us;
  std::optional<double> latency_p99_us;

  bool in_shared_memory() const { return transport == "shm"; }
  /// The share of all whole messages that it was not sent; where the wire was not measured, by payload.
  double saved() const;
  /// The two figures per sample that saved() compares: what it was sent, over what came and what was
  /// withheld, and the whole message.
  double sent_bytes_per_sample() const { return wire_bytes_per_sample.value_or(payload_bytes_per_sample); }
};

/// Over all subscribers that are not served in shared memory.
struct Carried {
  double bytes = 0;        ///< what they were sent
  double whole_bytes = 0;  ///< what sending all of them all whole messages would have been
  double saved() const { return whole_bytes > 0 ? 1 - bytes / whole_bytes : 0; }
};

struct RunFigures {
  std::string input;
  std::string message_shape;  ///< for people: "128 x 1024 points"
  double hz = 0;
  std::uint64_t samples = 0;
  std::uint64_t dropped = 0;  ///< of these: not handed over to every subscriber, since a queue was full
  unsigned hosts = 0;
  std::optional<double> idle_bytes_per_s;  ///< control traffic that one node sends, on average
  std::vector<SubscriberFigures> subscribers;

  bool real_hosts() const { return hosts > 1; }
  std::uint64_t lost() const;
  Carried carried() const;
};

nlohmann::ordered_json to_json(const RunFigures& figures);

/// "header, width", "all", "all but height, 1 Hz"
std::string format_request(const SubscriberFigures& subscriber);

}  // namespace sft::demo
