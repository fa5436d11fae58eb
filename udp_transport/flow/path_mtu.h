// The largest length of datagrams for one destination. The kernel knows it of the route, and of routers that
// have reported it (ICMP). It is shorter where a path drops long datagrams without a word (a black hole),
// which only the receiver's reports can show (length_monitor.h). The algorithm follows RFC 8899 with samples
// as probes: a reliable sample that a probe loses is sent again. The class is pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <limits>
#include <optional>

namespace sft::udp {

class PathMtu {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Long datagrams count as lost after this number of reports without them over this time: a queue that is
  /// full for a moment may lose a whole train.
  static constexpr int losses_max = 5;
  static constexpr std::chrono::milliseconds timeout{200};
  /// From one length that is found to work to the next, and from one that does not to the next try, at first
  /// and at last.
  static constexpr std::chrono::seconds search_pause{1}, retry_pause{10}, retry_pause_max{600};

  /// `headers`: bytes of IP and UDP. `shortest`: what every path takes.
  PathMtu(std::size_t headers, std::size_t shortest, std::size_t kernel_says);

  std::size_t datagram_bytes() const { return bytes_; }
  /// True if arrived() should be called.
  bool is_uncertain() const { return bytes_ < ceiling_ || losses_ > 0 || is_limited_; }

  void kernel_says(std::size_t bytes);
  /// The length of which it is known that longer datagrams do not arrive; 0 if all that the kernel sends do,
  /// as far as is known.
  std::size_t limited_to() const {
    if (!is_limited_) return 0;
    return proven_ != 0 ? proven_ : bytes_;
  }
  /// Datagrams of that length, or longer ones, were sent, and none has arrived.
  void lost(std::size_t length, Time now);
  /// The longest datagram that has arrived of late had that length.
  void arrived(std::size_t length, Time now);
  /// Tries the next greater length when it is time.
  void look_after(Time now);

 private:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  std::size_t packet(std::size_t ip_bytes) const { return ip_bytes - headers_; }
  std::size_t next_longer() const;
  void shorten(Time now);

  std::size_t headers_;
  std::size_t shortest_;
  std::size_t ceiling_;          ///< what the kernel says
  std::size_t bytes_;            ///< the present length of datagrams
  std::size_t proven_ = 0;       ///< the greatest that has arrived; 0: none has yet
  std::size_t too_long_ = none;  ///< did not arrive
  bool is_limited_ = false;      ///< it was shortened, and the ceiling has not arrived since
  Time next_try_{};
  Time::duration retry_after_ = retry_pause;
  int losses_ = 0;                  ///< without the arrival of something as long in between
  std::size_t lost_length_ = none;  ///< the shortest of these
  Time first_loss_{};
};

}  // namespace sft::udp
