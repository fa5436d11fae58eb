// The labels of the samples that were completed or given up most recently. Further datagrams of these
// samples are ignored.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class RecentLabels {
 public:
  RecentLabels() { keys_.fill(no_key); }
  bool contains(const SampleLabel& label) const {
    return std::find(keys_.begin(), keys_.end(), key(label)) != keys_.end();
  }
  void add(const SampleLabel& label) {
    keys_[next_] = key(label);
    next_ = (next_ + 1) % keys_.size();
  }

 private:
  static constexpr std::uint64_t no_key = UINT64_MAX;
  static std::uint64_t key(const SampleLabel& label) {
    return std::uint64_t{label.sequence} << 16 | label.variant;
  }
  std::array<std::uint64_t, 64> keys_;
  std::size_t next_ = 0;
};

}  // namespace sft::udp
