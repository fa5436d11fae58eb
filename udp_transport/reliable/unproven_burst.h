// Decides if more small samples may wait in a lane than its depth allows. They may until its receiver has
// reported, and for a short time after the report. So a whole burst is sent, and none of its samples is
// dropped in favour of newer ones. Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <optional>
#include <utility>

namespace sft::udp {

class UnprovenBurst {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// For this time after the report, more jobs than the depth may still wait.
  static constexpr std::chrono::milliseconds goes_on{250};

  /// Notes that a job is posted before the receiver has reported.
  void await_report(bool job_is_small) {
    awaits_report_ = true;
    small_ones_wait_ = small_ones_wait_ || job_is_small;
    reported_at_.reset();
  }
  bool awaits_report() const { return awaits_report_; }
  /// Notes that a job is posted, and that the receiver has reported since the previous job was posted.
  void reported(Time now) {
    awaits_report_ = false;
    if (std::exchange(small_ones_wait_, false)) reported_at_ = now;
  }
  /// Returns true for a short time after the report, if small jobs had waited for the report.
  bool is_just_reported(Time now) const { return reported_at_ && now - *reported_at_ < goes_on; }

 private:
  bool awaits_report_ = false;
  bool small_ones_wait_ = false;
  std::optional<Time> reported_at_;
};

}  // namespace sft::udp
