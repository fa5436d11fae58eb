// The rate at which a remote socket takes what it is sent: the best of late. Pure.
//
// A time there and back can be long for two reasons. Where the way or the receiver is slow, the rate is low,
// and a smaller window makes the queue shorter. Where a thread at one of the ends did not run for a while,
// the rate is high before and after, and a smaller window would only need more such round trips. The best
// rate tells the two apart: it says how much is taken within a given time.
//
// A rate is that of what passed while a mark and its report were under way, as in "Delivery Rate Estimation"
// (draft-cheng-iccrg-delivery-rate-estimation): reports that come all at once, after a pause, do not make
// it higher than it was.
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

  /// A rate counts for so long, and until there is another one.
  static constexpr std::chrono::milliseconds valid_for{250};

  /// A mark is sent.
  void mark(Time now) { marks_[next_++ % marks_.size()] = {now, reported_}; }
  /// The report of the mark of that time has come: everything up to `position` has passed.
  void report(std::uint64_t position, Time marked_at, Time now) {
    for (const Mark& mark : marks_) {
      if (mark.sent_at == marked_at) note(position - mark.reported.position, now - mark.reported.at, now);
    }
    reported_ = {position, now};
  }

  /// Returns the bytes that are taken within so long, at the best rate of late; 0: not known.
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
    Passed reported{};  ///< when it was sent
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
  std::array<Mark, 8> marks_{};  ///< the latest
  std::size_t next_ = 0;
  // Bytes for each tick of the clock.
  double now_ = 0;     ///< the best since `since_`
  double before_ = 0;  ///< the best of the time before that
  Time since_{};
};

}  // namespace sft::udp
