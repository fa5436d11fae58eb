// Passes samples one after the other from one process to another.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/pair.h"

namespace sft::bench {

enum class Reading { spinning, sleeping };

struct Transfer {
  std::uint64_t messages = 0;
  Reading reading = Reading::sleeping;
  bool preparing_counts = false;
};

/// Sends each sample after the previous sample was read. The pause before each sample is so long that a
/// reader that does not spin falls asleep.
void send_each(Exchange& exchange, const Transfer& transfer, Writer& writer);
/// Takes each sample and notes its receipt.
void receive_each(Exchange& exchange, const Transfer& transfer, Reader& reader);

/// Returns the one-way times in microseconds from publish() until the reader has taken the sample.
std::vector<double> transfer_times(Contender contender, const Topic& topic, const Transfer& transfer);

}  // namespace sft::bench
