// UnprovenBudget limits what is sent to all destinations on one host together before they report. FlowLimits
// allows a few datagrams and flow marks (requests for a report) for each destination alone. The budget
// limits their sum, even if forged announcements name many destinations on the host. Any thread may call the
// functions.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>

#include "core/platform/ip_address.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

namespace sft::udp {

class UnprovenBudget {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr std::size_t datagrams_max = 64;
  /// The time after which the budget grows by one datagram.
  static constexpr std::chrono::seconds refill{1};
  /// For this time after a report, a host counts as answering.
  static constexpr std::chrono::seconds answers_for{10};

  std::size_t left(Time now) {
    const core::Lock lock(mutex_);
    recover(now);
    return datagrams_max - spent_;
  }
  void spend(std::size_t datagrams, Time now) {
    const core::Lock lock(mutex_);
    recover(now);
    spent_ = std::min(spent_ + datagrams, datagrams_max);
  }
  /// Returns the datagrams to the budget that were sent to a destination before it reported.
  void give_back(std::size_t datagrams) {
    const core::Lock lock(mutex_);
    spent_ -= std::min(spent_, datagrams);
  }
  /// Notes that a destination on the host has reported. For `answers_for`, flow marks to the host are not
  /// limited.
  void answered(Time now) {
    const core::Lock lock(mutex_);
    answered_at_ = now;
  }
  /// Returns true if one more flow mark may be sent to a destination that has used up its own allowance.
  /// Then counts the mark.
  bool takes_mark(Time now) {
    const core::Lock lock(mutex_);
    if (answered_at_ && now - *answered_at_ < answers_for) return true;
    recover(now);
    if (spent_ == datagrams_max) return false;
    ++spent_;
    return true;
  }
  bool is_unused(Time now) { return left(now) == datagrams_max; }

 private:
  void recover(Time now) SFT_REQUIRES(mutex_) {
    if (spent_ == 0) since_ = now;
    const auto steps = static_cast<std::size_t>(std::max<Time::duration>(now - since_, {}) / refill);
    since_ += steps * refill;
    spent_ -= std::min(spent_, steps);
  }

  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::facts) SFT_ACQUIRED_BEFORE(core::lock_order::jobs);
  std::size_t spent_ SFT_GUARDED_BY(mutex_) = 0;
  Time since_ SFT_GUARDED_BY(mutex_){};  ///< time of the last reduction of `spent_`
  std::optional<Time> answered_at_ SFT_GUARDED_BY(mutex_){};
};

/// The budgets of all hosts. The class is not thread-safe.
class UnprovenBudgets {
 public:
  std::shared_ptr<UnprovenBudget> of(const core::IpAddress& host, UnprovenBudget::Time now) {
    std::erase_if(budgets_, [&](const auto& entry) {
      return entry.second.use_count() == 1 && entry.second->is_unused(now);
    });
    std::shared_ptr<UnprovenBudget>& budget = budgets_[host];
    if (budget == nullptr) budget = std::make_shared<UnprovenBudget>();
    return budget;
  }

 private:
  std::map<core::IpAddress, std::shared_ptr<UnprovenBudget>> budgets_;
};

}  // namespace sft::udp
