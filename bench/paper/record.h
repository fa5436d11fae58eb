// A record is the costs of one contender in one phase of a session, and a case what the session sends there.
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

/// The fields that a receiver requires: each field independently of all others. The same arguments give the
/// same fields on every machine. No field at all is a possible result, and is kept.
FieldSet draw_fields(std::uint64_t seed, const Configuration& of, std::size_t repeat, std::size_t receiver);

/// The fewest bytes of frames that carry a message of so many bytes of CDR, with no header but those of
/// Ethernet, IPv4 and UDP. All frames but the last one are full at an MTU of 1500. An empty message takes one
/// frame.
std::size_t least_bytes(std::size_t cdr_bytes);

/// The messages of a case: those of the parametric study, or those that have a name.
struct Case {
  std::string name;               ///< "parametric", "laserscan", ...
  Configuration configuration{};  ///< of a parametric case; of others the number of receivers counts only
  std::size_t repeat = 0;
};

/// One receiver. All bytes are of a message.
struct Received {
  FieldSet fields = 0;     ///< that it reads
  double cdr_bytes = 0;    ///< of the fields that it reads
  double least_bytes = 0;  ///< on the wire, to carry these
  double bytes = unknown;  ///< of its host's interface, both ways, beyond idle traffic
  double lost = unknown;   ///< share of the messages that did not arrive
};

struct Record {
  Case of;
  Contender contender{};
  std::vector<Received> receivers{};
  double sender_bytes = unknown;               ///< of a message, as those of a receiver
  double idle_bytes_per_s = unknown;           ///< of the sender's host without messages
  double idle_receiver_bytes_per_s = unknown;  ///< of all receivers' hosts together
  double p50_us = unknown;  ///< from the call until the receiver has its fields, over all receivers
  double p99_us = unknown;
  double cpu_us = unknown;          ///< of a message, all processes, with what they take when idle
  double resident_bytes = unknown;  ///< of all processes, at the end of the session

  /// The machine stopped the writer so long that messages may have been counted in another phase.
  bool disturbed = false;

  /// The sum of one of the bytes over all receivers.
  double sum(double Received::*bytes) const {
    double sum = 0;
    for (const Received& one : receivers) sum += one.*bytes;
    return sum;
  }
  double received_bytes() const { return sum(&Received::bytes); }
  double least_bytes() const { return sum(&Received::least_bytes); }
};

}  // namespace sft::bench::paper
