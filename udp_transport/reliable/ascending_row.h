// Counts datagrams in a row whose sequences ascend: a repetition, or one from before, begins another row.
// Pure.
#pragma once

#include <chrono>
#include <cstdint>

namespace sft::udp {

class AscendingRow {
 public:
  using Time = std::chrono::steady_clock::time_point;

  void add(std::uint64_t sequence, Time now) {
    count_ = count_ > 0 && sequence <= last_ ? 1 : count_ + 1;
    if (count_ == 1) since_ = now;
    last_ = sequence;
  }
  /// Adds a datagram that belongs to the row whether it ascends or not. Returns true if it ascends.
  bool add_in_any_order(std::uint64_t sequence, Time now) {
    const bool ascends = count_ > 0 && sequence > last_;
    if (count_++ == 0) since_ = now;
    last_ = sequence;
    return ascends;
  }
  /// The next datagram begins another row.
  void end() { count_ = 0; }

  std::uint32_t count() const { return count_; }
  /// The time from the first datagram of the row until `now`.
  Time::duration lasts(Time now) const { return now - since_; }

 private:
  std::uint32_t count_ = 0;
  std::uint64_t last_ = 0;
  Time since_{};
};

}  // namespace sft::udp
