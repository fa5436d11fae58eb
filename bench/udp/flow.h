// Samples of SFT at a steady pace from one host to another, and what passes the sender's interface meanwhile.
#pragma once

#include <cstdint>
#include <limits>

#include "bench/common/hosts.h"
#include "bench/udp/contender.h"

namespace sft::bench {

struct Flow {
  Topic topic;
  std::uint64_t samples = 0;
  std::int64_t period_us = 0;
};

/// Not numbers if samples were missing.
struct Passage {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  double link_bytes = unknown;         ///< that were sent, less those in as much time without samples
  double control_bytes = unknown;      ///< of SFT's datagrams that carry no samples, both ways
  double control_datagrams = unknown;  ///< likewise
  double seconds = unknown;
};

Passage pass(const Flow& flow, const TwoHosts& hosts);

}  // namespace sft::bench
