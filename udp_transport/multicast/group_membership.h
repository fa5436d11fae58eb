// The writer's state of one member of a multicast group. It shows if samples that are sent to the group
// arrive at the member. Uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace sft::udp {

/// The pause between reports of a member while it receives samples of a group.
inline constexpr std::chrono::milliseconds group_report_pause{900};

class GroupMembership {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Returns true if the member has reported in time. Then no separate copy is sent to it.
  bool hears() const { return hears_; }

  /// Notes that a sample was sent to the group.
  void sent(Time now) {
    sent_since_offer_ = true;
    if (hears_ && owed_since_ == never && now - reported_at_ >= report_expected) owed_since_ = now;
  }

  /// Notes that the member has reported the arrival of the group's sample with the ordinal `heard`.
  void reported(std::uint64_t heard, Time now) {
    if (heard <= refused_at_) return;  // the report is about a sample from before refused()
    hears_ = true;
    reported_at_ = now;
    owed_since_ = never;
    pause_ = offer_pause_least;
    unanswered_ = 0;
  }

  /// Notes that the member must have received a wrong offer: samples of the group do not fit its channel as
  /// the offer says, or no sample arrives. `last` is the ordinal of the last sample that was sent to the
  /// group.
  void refused(std::uint64_t last, Time now) {
    refused_at_ = last;
    if (!hears_) return;  // the group will be offered to the member again
    lose(now);
  }

  /// Returns true if the member has not answered `offers_max` offers, so that multicast probably does not
  /// reach it at all.
  bool given_up() const { return unanswered_ >= offers_max; }

  /// Checks if a report of the member is overdue.
  void look(Time now) {
    if (owed_since_ != never && now - owed_since_ >= timeout) lose(now);
  }

  /// Returns true if the group should be offered to the member now. Then counts it as offered. The next
  /// offer is due only after a further sample, which the member could have received.
  bool offer_due(Time now) {
    if (hears_ || !sent_since_offer_ || now < offer_at_) return false;
    sent_since_offer_ = false;
    ++unanswered_;
    offer_at_ = now + pause_;
    pause_ = std::min(2 * pause_, offer_pause_longest);
    return true;
  }

 private:
  static constexpr std::chrono::milliseconds report_expected{1000};
  static constexpr std::chrono::milliseconds timeout{500};
  static constexpr std::chrono::milliseconds offer_pause_least{20};
  static constexpr std::chrono::milliseconds offer_pause_longest{2000};

  void lose(Time now) {
    hears_ = false;
    owed_since_ = never;
    offer_at_ = now;
    sent_since_offer_ = true;
  }

  static constexpr int offers_max = 9;  ///< 9 offers take about 5 s if samples are sent meanwhile
  static constexpr Time never = Time::max();

  bool hears_ = false;
  /// Only a report with a greater ordinal shows that the member receives the group.
  std::uint64_t refused_at_ = 0;
  bool sent_since_offer_ = true;
  Time offer_at_{};
  std::chrono::milliseconds pause_ = offer_pause_least;
  int unanswered_ = 0;
  Time reported_at_{};
  Time owed_since_ = never;  ///< time of the first sample that should have caused a report
};

}  // namespace sft::udp
