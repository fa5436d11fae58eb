// One change of recorded fields, message by message: the response-time trace of the paper.
#pragma once

#include <iosfwd>
#include <optional>
#include <vector>

namespace sft::bench::paper {

/// The events during a change of the recorded fields. Times are in milliseconds since the first message was
/// published.
struct Trace {
  struct Message {
    double at_ms = 0;      ///< time when the receiver got the message
    double cdr_bytes = 0;  ///< bytes of the fields in the message
  };
  std::vector<Message> messages{};
  double changed_ms =
      0;  ///< time when the receiver's program had read the message after which SFT requests fewer fields
  /// Time when the publisher began to send only the fields that the receiver requests.
  double applied_ms = 0;

  double response_us() const { return 1000 * (applied_ms - changed_ms); }
};

/// Runs a receiver with recorded fields that reads half of the 7 fields of 512 bytes each, at 10 messages
/// per second. Returns nothing if the publisher did not apply the receiver's request.
std::optional<Trace> response_trace();

/// Writes comma-separated values: a row for each message, one for changed_ms, and one for applied_ms.
void write(std::ostream& out, const Trace& trace);

}  // namespace sft::bench::paper
