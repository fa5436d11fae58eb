// A writer's knowledge of one member of a multicast group: whether samples that are sent to the group arrive
// at the member. The class is pure: calls and times go in, answers come out.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace sft::udp {

/// While it hears samples of a group, a member reports so often.
inline constexpr std::chrono::milliseconds group_report_pause{900};

class GroupMembership {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// True if the member has reported lately enough: it needs no copy of its own.
  bool hears() const { return hears_; }

  /// A sample was sent to the group.
  void sent(Time now) {
    sent_since_offer_ = true;
    if (hears_ && owed_since_ == never && now - reported_at_ >= report_expected) owed_since_ = now;
  }

  /// Tells that the member has heard the sample with that ordinal.
  void reported(std::uint64_t heard, Time now) {
    if (heard <= refused_at_) return;  // it says that of before
    hears_ = true;
    reported_at_ = now;
    owed_since_ = never;
    pause_ = offer_pause_least;
    unanswered_ = 0;
  }

  /// The member must have got a wrong offer: samples have no place where it says, or none come.
  /// `last`: ordinal of the last sample that was sent to the group.
  void refused(std::uint64_t last, Time now) {
    refused_at_ = last;
    if (!hears_) return;  // it is offered again anyway
    lose(now);
  }

  /// True if the group was offered so often that multicast seems not to reach the member at all.
  bool given_up() const { return unanswered_ >= offers_max; }

  /// Notices what did not come.
  void look(Time now) {
    if (owed_since_ != never && now - owed_since_ >= timeout) lose(now);
  }

  /// Returns true if the group is to be offered to the member now; it then counts as offered. It is not
  /// offered again before something was sent that the member could have heard.
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

  static constexpr int offers_max = 9;  ///< some 5 s, if samples are sent meanwhile
  static constexpr Time never = Time::max();

  bool hears_ = false;
  std::uint64_t refused_at_ = 0;  ///< only what it hears behind this tells that it hears again
  bool sent_since_offer_ = true;
  Time offer_at_{};
  std::chrono::milliseconds pause_ = offer_pause_least;
  int unanswered_ = 0;
  Time reported_at_{};
  Time owed_since_ = never;  ///< a sample was sent that it should have reported
};

}  // namespace sft::udp
