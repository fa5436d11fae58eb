#include "bench/paper/record.h"

#include <numeric>

namespace sft::bench::paper {

double Record::received_bytes() const {
  return std::accumulate(receivers.begin(), receivers.end(), 0.,
                         [](double sum, const Received& one) { return sum + one.bytes; });
}

double Record::least_bytes() const {
  return std::accumulate(receivers.begin(), receivers.end(), 0.,
                         [](double sum, const Received& one) { return sum + one.least_bytes; });
}

}  // namespace sft::bench::paper
