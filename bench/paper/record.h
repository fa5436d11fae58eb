// A record is the costs of one contender in one phase of a session.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "bench/paper/configuration.h"
#include "bench/paper/contender.h"

namespace sft::bench::paper {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

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

  double received_bytes() const;  ///< of all receivers
  double least_bytes() const;     ///< for all receivers
};

}  // namespace sft::bench::paper
