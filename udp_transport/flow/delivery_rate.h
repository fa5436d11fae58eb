// The best recent rate at which a remote socket takes the bytes that are sent to it. Uses no clock, thread
// or I/O.
//
// A round trip can be long for two reasons. If the path or the receiver is slow, the rate is low, and a
// smaller window makes the queue shorter. If a thread of the sender or the receiver did not run for a while,
// the rate is high before and after that pause. A smaller window would not shorten such a round trip. The
// best recent rate distinguishes the two cases.
//
// A rate is the number of bytes that arrived while a flow mark and its report were under way, divided by
// that time, as in "Delivery Rate Estimation" (draft-cheng-iccrg-delivery-rate-estimation). So several
// reports that come at once after a pause do not raise the rate.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

class DeliveryRate {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// The length of a period of measurement. The best rate of a period counts until the end of the next
  /// period.
  static constexpr std::chrono::milliseconds valid_for{250};

  /// Notes that a flow mark is sent.
  void mark(Time now) { marks_[next_++ % marks_.size()] = {now, reported_}; }
  /// Notes the report that answers the flow mark sent at `marked_at`: all bytes up to `position` have
  /// passed.
  void report(std::uint64_t position, Time marked_at, Time now) {
    for (const Mark& mark : marks_) {
      if (mark.sent_at == marked_at) note(position - mark.reported.position, now - mark.reported.at, now);
    }
    reported_ = {position, now};
  }

  /// Returns the number of bytes that the receiver takes within `time` at the best recent rate; 0 if no rate
  /// is known.
  std::size_t bytes_within(Time::duration time) const {
    const double bytes = std::max(before_, now_) * static_cast<double>(time.count());
    return static_cast<std::size_t>(std::min(bytes, 1e15));
  }

 private:
  struct Passed {
    std::uint64_t position = 0;
    Time at{};
  };
  struct Mark {
    Time sent_at{};
    Passed reported{};  ///< the latest report at the time when the flow mark was sent
  };

  void note(std::uint64_t bytes, Time::duration time, Time now) {
    if (time <= Time::duration{}) return;
    const double rate = static_cast<double>(bytes) / static_cast<double>(time.count());
    if (now - since_ >= valid_for) {
      before_ = now_;
      now_ = 0;
      since_ = now;
    }
    now_ = std::max(now_, rate);
  }

  Passed reported_;
  std::array<Mark, 8> marks_{};  ///< the latest flow marks
  std::size_t next_ = 0;
  // Rates, in bytes per tick of the clock.
  double now_ = 0;     ///< the best rate since `since_`
  double before_ = 0;  ///< the best rate of the previous period
  Time since_{};
};

}  // namespace sft::udp
