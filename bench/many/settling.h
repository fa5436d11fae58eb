// Finds out when the bytes of a sample have settled, from the bytes that were counted at each sample.
#pragma once

#include <cstdint>
#include <vector>

namespace sft::bench {

/// Bytes that the host had sent just before a sample was published.
struct Counted {
  std::int64_t at_ns = 0;
  std::int64_t bytes = 0;
};

/// The time in milliseconds from `begin_ns` until the mean of the following samples stays within 5 % of the
/// final figure, which is the mean of the last half of all samples. 0 if it was so before; not a number if
/// there are too few samples to tell.
double settled_ms(const std::vector<Counted>& samples, std::int64_t begin_ns);

}  // namespace sft::bench
