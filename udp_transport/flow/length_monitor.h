// Finds out from reports if long datagrams arrive at a receiver. A path may drop long datagrams without an
// error although short ones, such as flow marks, arrive. The class compares the lengths of sent datagrams
// with the longest datagram that the receiver reports as recently received (LongestArrivals). This
// comparison needs no acks, so it works for best effort, too, and for samples of any size. The class uses no
// clock, thread or I/O.
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

  /// A report is evidence about a datagram only if the flow mark that requested the report was sent within
  /// this time after the datagram. The receiver may have discarded the lengths of earlier datagrams.
  static constexpr std::chrono::milliseconds remembered_for{500};

  /// Notes that datagrams were sent. `length` is the length of the longest of them.
  void sent(std::size_t length, Time now) {
    if (length > arrived_) since_mark_.add(length, now);
  }
  /// Notes that a flow mark was sent after the datagrams that sent() has noted. Its report is evidence about
  /// the datagrams since the previous mark.
  void mark(std::uint64_t position) {
    if (!marked_.is_empty()) return;
    marked_ = std::exchange(since_mark_, {});
    position_ = position;
  }
  /// Notes that the receiver requests data again, so that the next report should come soon.
  void asked_again() { unconfirmed_ = true; }
  /// Returns true if long datagrams might not arrive. Then the caller should send a flow mark soon after
  /// them.
  bool is_uncertain() const { return unconfirmed_; }

  /// Evaluates the report that answers the flow mark sent at `marked_at`. Returns the length of datagrams
  /// that have not arrived; 0 if the report shows no loss.
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
  /// Lengths of sent datagrams that are longer than any datagram known to have arrived.
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

  std::size_t arrived_ = 0;  ///< length of the longest datagram in the last report
  Lengths since_mark_, marked_;
  std::uint64_t position_ = 0;  ///< the position of the flow mark whose report is evaluated next
  bool unconfirmed_ = false;
};

}  // namespace sft::udp
