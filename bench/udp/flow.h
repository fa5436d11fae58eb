// Sends samples of SFT at a steady pace from one host to another, and counts the bytes at the sender's
// interface.
#pragma once

#include <cstdint>
#include <limits>

#include "bench/common/contender.h"
#include "bench/common/hosts.h"

namespace sft::bench {

struct Flow {
  Topic topic;
  std::uint64_t samples = 0;
  std::int64_t period_us = 0;
};

/// The traffic of samples. All figures are not a number if samples were missing.
struct Passage {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  double link_bytes = unknown;         ///< bytes sent, minus those in as much time without samples
  double control_bytes = unknown;      ///< bytes of SFT's datagrams without samples, in both directions
  double control_datagrams = unknown;  ///< number of these datagrams
  double seconds = unknown;
};

Passage pass(const Flow& flow, const TwoHosts& hosts);

}  // namespace sft::bench
