// One change of recorded fields, from message to message: the response-time trace of the paper.
#pragma once

#include <iosfwd>
#include <optional>
#include <vector>

namespace sft::bench::paper {

/// Times are in milliseconds since the first message was published.
struct Trace {
  struct Message {
    double at_ms = 0;      ///< when the receiver had it
    double cdr_bytes = 0;  ///< that it brought
  };
  std::vector<Message> messages{};
  double changed_ms =
      0;  ///< the receiver's program has read the message after which SFT asks for fewer fields
  double applied_ms = 0;  ///< the publisher sends only these from here on

  double response_us() const { return 1000 * (applied_ms - changed_ms); }
};

/// A receiver with recorded fields that reads half of the 7 fields of 512 bytes each, at 10 messages a
/// second. Nothing if the publisher did not apply its request.
std::optional<Trace> response_trace();

/// Comma-separated values: a line for each message, and one for each of both moments.
void write(std::ostream& out, const Trace& trace);

}  // namespace sft::bench::paper
