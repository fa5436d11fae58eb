// Finds by reports whether long datagrams arrive at a receiver: a path may drop these without an error
// although short ones, as marks are, get through. Compares the lengths of what was sent with the longest
// datagram that the receiver says has come of late (LongestArrivals). This needs no acks, so that it holds
// for best effort, and for samples of any size. The class is pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class LengthMonitor {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A report is no evidence about what was sent longer before its mark than this: the receiver may have
  /// forgotten it.
  static constexpr std::chrono::milliseconds remembered_for{500};

  /// Datagrams were sent, of which the longest had that length.
  void sent(std::size_t length, Time now) {
    if (length > arrived_) since_mark_.add(length, now);
  }
  /// A mark was sent behind them. One report is evidence about the datagrams between two marks.
  void mark(std::uint64_t position) {
    if (!marked_.is_empty()) return;
    marked_ = std::exchange(since_mark_, {});
    position_ = position;
  }
  /// The receiver asks for something again: the next report should come soon.
  void asked_again() { unconfirmed_ = true; }
  /// Long datagrams may not arrive: marks should follow them soon.
  bool is_uncertain() const { return unconfirmed_; }

  /// Returns the length of datagrams that have not arrived; 0 if all have, as far as the report shows.
  std::size_t evaluate(const FlowReport& report, Time marked_at) {
    arrived_ = report.longest;
    if (report.position < position_) return 0;
    const Lengths sent = std::exchange(marked_, {});
    const bool is_evidence = report.longest != 0 && marked_at - sent.last <= remembered_for;
    unconfirmed_ = is_evidence && sent.longest > report.longest;
    if (!unconfirmed_) return 0;
    return sent.shortest > report.longest ? sent.shortest : sent.longest;
  }

 private:
  /// Of datagrams that are longer than those that have arrived.
  struct Lengths {
    std::size_t shortest = SIZE_MAX, longest = 0;
    Time last{};

    bool is_empty() const { return longest == 0; }
    void add(std::size_t length, Time now) {
      shortest = std::min(shortest, length);
      longest = std::max(longest, length);
      last = now;
    }
  };

  std::size_t arrived_ = 0;  ///< the longest by the last report
  Lengths since_mark_, marked_;
  std::uint64_t position_ = 0;  ///< the position of the mark whose report is evaluated next
  bool unconfirmed_ = false;
};

}  // namespace sft::udp
