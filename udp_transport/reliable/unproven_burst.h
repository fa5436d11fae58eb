// Tells whether small samples may pile up in a lane beyond its depth: while its receiver does not report, and
// for a moment after the report, so that a burst is sent before any of its samples is dropped for others.
// Pure.
#pragma once

#include <chrono>
#include <optional>
#include <utility>

namespace sft::udp {

class UnprovenBurst {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// What has piled up may go on for so long after the report.
  static constexpr std::chrono::milliseconds goes_on{250};

  /// A job is posted, and the receiver has not reported.
  void await_report(bool job_is_small) {
    awaits_report_ = true;
    small_ones_wait_ = small_ones_wait_ || job_is_small;
    reported_at_.reset();
  }
  bool awaits_report() const { return awaits_report_; }
  /// A job is posted, and the receiver has reported since the job before.
  void reported(Time now) {
    awaits_report_ = false;
    if (std::exchange(small_ones_wait_, false)) reported_at_ = now;
  }
  /// True for a moment after the report, if small jobs had waited for it.
  bool is_just_reported(Time now) const { return reported_at_ && now - *reported_at_ < goes_on; }

 private:
  bool awaits_report_ = false;
  bool small_ones_wait_ = false;
  std::optional<Time> reported_at_;
};

}  // namespace sft::udp
