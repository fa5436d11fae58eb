// Determines when the bytes of a sample have settled, from the bytes that were counted at each sample.
#pragma once

#include <cstdint>
#include <vector>

namespace sft::bench {

/// The total number of bytes that the host had sent by the time `at_ns`, just before a sample was published.
struct Counted {
  std::int64_t at_ns = 0;
  std::int64_t bytes = 0;
};

/// Returns the time in milliseconds from `begin_ns` until the mean of the following samples stays within 5
/// % of the final value, which is the mean of the last half of all samples. Returns 0 if the mean did so
/// before `begin_ns`, and NaN if there are too few samples.
double settled_ms(const std::vector<Counted>& samples, std::int64_t begin_ns);

}  // namespace sft::bench
