// A record has the costs of one contender in one phase of a session. A case describes the messages of that
// phase.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "bench/common/contender.h"
#include "bench/paper/contender.h"

namespace sft::bench::paper {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
inline constexpr std::size_t receivers_max = 3;

/// A configuration of the paper's parametric study.
struct Configuration {
  std::size_t fields = 0;
  std::size_t field_bytes = 0;
  std::size_t receivers = 0;
  int percent = 0;  ///< the probability that a receiver requires a field

  friend auto operator<=>(const Configuration&, const Configuration&) = default;
};

/// Draws the fields that a receiver requires, each field independently of all others. The same arguments
/// give the same fields on every machine. An empty result is possible, and is not replaced.
FieldSet draw_fields(std::uint64_t seed, const Configuration& of, std::size_t repeat, std::size_t receiver);

/// Returns the fewest bytes of frames that carry a message of `cdr_bytes` bytes, with only the headers of
/// Ethernet, IPv4 and UDP. All frames but the last one are full at an MTU of 1500. An empty message takes
/// one frame.
std::size_t least_bytes(std::size_t cdr_bytes);

/// The messages of a case: messages of the parametric study, or messages with a name.
struct Case {
  std::string name;  ///< the name: "parametric", "laserscan", ...
  /// The configuration of a parametric case. In other cases only its number of receivers is used.
  Configuration configuration{};
  std::size_t repeat = 0;
};

/// The results of one receiver. All numbers of bytes are per message.
struct Received {
  FieldSet fields = 0;     ///< the fields that the receiver reads
  double cdr_bytes = 0;    ///< bytes of the fields that the receiver reads
  double least_bytes = 0;  ///< the fewest bytes on the wire that carry these fields
  /// Bytes of the interface of the receiver's host in both directions, without idle traffic.
  double bytes = unknown;
  double lost = unknown;  ///< the share of the messages that did not arrive
};

struct Record {
  Case of;
  Contender contender{};
  std::vector<Received> receivers{};
  /// Bytes per message of the sender's host in both directions, without idle traffic.
  double sender_bytes = unknown;
  /// Median time from the writing call until a receiver has its fields.
  double p50_us = unknown;
  double cpu_us = unknown;          ///< CPU time per message, of all processes, idle work included
  double resident_bytes = unknown;  ///< memory of all processes at the end of the session

  /// True if the machine stopped the writer for so long that messages may have been counted in another phase.
  bool disturbed = false;

  /// Returns the sum of one of the members over all receivers.
  double sum(double Received::*bytes) const {
    double sum = 0;
    for (const Received& one : receivers) sum += one.*bytes;
    return sum;
  }
  double received_bytes() const { return sum(&Received::bytes); }
  double least_bytes() const { return sum(&Received::least_bytes); }
};

}  // namespace sft::bench::paper
