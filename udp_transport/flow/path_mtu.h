// The largest length of datagrams for one destination. The kernel knows the limits of the route, and the
// limits that routers have reported (ICMP). A path that silently drops long datagrams (a black hole) has a
// smaller limit, which only the receiver's reports can show (length_monitor.h). The algorithm follows RFC
// 8899, but uses samples as probes. A reliable sample whose datagrams are too long and lost is sent again.
// The class uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <cstddef>
#include <limits>
#include <optional>

namespace sft::udp {

class PathMtu {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Long datagrams count as too long after `losses_max` reports in a row that show their loss, over at
  /// least `timeout`. A single loss is no evidence, because a queue that is full for a moment may lose a
  /// whole train of datagrams.
  static constexpr int losses_max = 5;
  static constexpr std::chrono::milliseconds timeout{200};
  /// Pauses of the search for longer datagrams. `search_pause` follows a length that works. `retry_pause` is
  /// the first pause before a failed length is tried again, and `retry_pause_max` is the longest one.
  static constexpr std::chrono::seconds search_pause{1}, retry_pause{10}, retry_pause_max{600};

  /// `headers` is the length of the IP and UDP headers. `shortest` is a length of datagrams that every path
  /// carries. `kernel_says` is the kernel's limit. All are in bytes.
  PathMtu(std::size_t headers, std::size_t shortest, std::size_t kernel_says);

  std::size_t datagram_bytes() const { return bytes_; }
  /// Returns true if arrived() should be called when long datagrams arrive.
  bool is_uncertain() const { return bytes_ < ceiling_ || losses_ > 0 || is_limited_; }

  void kernel_says(std::size_t bytes);
  /// Returns the length above which datagrams are known not to arrive; 0 if no such length is known.
  std::size_t limited_to() const {
    if (!is_limited_) return 0;
    return proven_ != 0 ? proven_ : bytes_;
  }
  /// Notes that a report shows the loss of datagrams of that length or longer: some were sent, and none has
  /// arrived.
  void lost(std::size_t length, Time now);
  /// Notes the length of the longest datagram that has arrived recently.
  void arrived(std::size_t length, Time now);
  /// Tries the next greater length if the pause of the search is over.
  void look_after(Time now);

 private:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  std::size_t packet(std::size_t ip_bytes) const { return ip_bytes - headers_; }
  std::size_t next_longer() const;
  void shorten(Time now);

  std::size_t headers_;
  std::size_t shortest_;
  std::size_t ceiling_;          ///< the kernel's limit of the length
  std::size_t bytes_;            ///< the present length of datagrams
  std::size_t proven_ = 0;       ///< the greatest length of a datagram that has arrived; 0: none
  std::size_t too_long_ = none;  ///< a length of datagrams that did not arrive
  /// True if `bytes_` was reduced, and no datagram of the length `ceiling_` has arrived since then.
  bool is_limited_ = false;
  Time next_try_{};
  Time::duration retry_after_ = retry_pause;
  int losses_ = 0;                  ///< number of reports in a row that show losses
  std::size_t lost_length_ = none;  ///< length of the shortest lost datagram in these reports
  Time first_loss_{};
};

}  // namespace sft::udp
