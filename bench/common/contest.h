// Short operations, timed against each other: in turns, in batches that are long against the clock's
// resolution. The best batch counts: whatever else the machine does only adds to a time.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace sft::bench {

/// What an operation wrote is used, and what it reads may have changed.
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

/// Nanoseconds of one operation of each.
std::vector<double> best_times_ns(std::vector<Batch> contenders, int rounds);

}  // namespace sft::bench
