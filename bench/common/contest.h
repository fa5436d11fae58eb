// Compares the times of short operations. The contenders run in turns, in batches that are long compared
// with the clock's resolution. The fastest batch counts, since other work of the machine can only increase
// a time.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace sft::bench {

/// Tells the compiler that all memory was read and may have changed, so that it optimises no operation away.
inline void clobber_memory() { asm volatile("" ::: "memory"); }

template <class T>
void keep(const T& value) {
  asm volatile("" : : "r,m"(value) : "memory");
}

using Batch = std::function<void(std::size_t times)>;

template <class Operation>
Batch batch_of(Operation operation) {
  return [operation](std::size_t times) mutable {
    for (std::size_t i = 0; i < times; ++i) {
      operation();
      clobber_memory();
    }
  };
}

/// Returns the best time in nanoseconds of one operation of each contender.
std::vector<double> best_times_ns(std::vector<Batch> contenders, int rounds);

}  // namespace sft::bench
