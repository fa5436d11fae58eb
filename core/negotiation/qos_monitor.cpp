#include "core/negotiation/qos_monitor.h"

#include <algorithm>
#include <utility>

namespace sft::core {

namespace {

using std::chrono::nanoseconds;

std::optional<nanoseconds> shorter(std::optional<nanoseconds> a, std::optional<nanoseconds> b) {
  if (!a || !b) return a ? a : b;
  return std::min(*a, *b);
}

std::optional<nanoseconds> pace_of(const std::optional<ActivityMonitor>& monitor) {
  return monitor ? std::optional(monitor->pace()) : std::nullopt;
}

}  // namespace

std::uint64_t ActivityMonitor::look(std::uint64_t count, Time now) {
  if (count != count_) {
    count_ = count;
    active_at_ = now;
    reported_ = 0;
    return 0;
  }
  const auto periods = static_cast<std::uint64_t>(std::max<std::int64_t>(0, (now - active_at_) / period_));
  return periods - std::exchange(reported_, std::max(reported_, periods));
}

OfferMonitor::OfferMonitor(const Qos& offered, Time now) : qos_(offered) {
  if (qos_.deadline.count() != 0) deadline_.emplace(qos_.deadline, 0, now);
  if (qos_.liveliness == Liveliness::manual_by_topic) lease_.emplace(qos_.liveliness_lease, 0, now);
}

void OfferMonitor::look(const Signs& signs, Time now) {
  if (deadline_) deadlines_missed_ += deadline_->look(signs.published, now);
  if (lease_) lease_->look(signs.published + signs.asserted, now);
}

bool OfferMonitor::assertion_due(const Signs& signs, bool samples_assert, Time now) {
  if (qos_.liveliness_lease.count() == 0) return false;
  const bool published = signs.published != reported_.published;
  if (published && samples_assert) {
    reported_ = signs;
    reported_at_ = now;
    return false;
  }
  const bool news =
      qos_.liveliness == Liveliness::automatic || published || signs.asserted != reported_.asserted;
  if (!news || rests(now)) return false;
  reported_ = signs;
  reported_at_ = now;
  return true;
}

std::optional<nanoseconds> OfferMonitor::pace() const {
  std::optional<nanoseconds> assertions;
  if (qos_.liveliness_lease.count() != 0) assertions = qos_.liveliness_lease / (2 * assertions_per_lease);
  return shorter(pace_of(deadline_), assertions);
}

RequestMonitor::RequestMonitor(const Qos& offered, const Qos& requested, std::uint64_t arrived, Time now) {
  if (requested.deadline.count() != 0) deadline_.emplace(requested.deadline, arrived, now);
  if (requested.liveliness_lease.count() == 0 || offered.liveliness_lease.count() == 0) return;
  // The writer promised its own lease, which is at most as long as the requested one. But a lease that is
  // too short for any writer must not cause checks all the time.
  const bool may_be_kept = offered.liveliness_lease >= shortest_offer;
  lease_.emplace(may_be_kept ? offered.liveliness_lease : requested.liveliness_lease, arrived, now);
}

std::uint64_t RequestMonitor::look(std::uint64_t arrived, Time now) {
  if (lease_) lease_->look(arrived + assertions_, now);
  return deadline_ ? deadline_->look(arrived, now) : 0;
}

std::optional<nanoseconds> RequestMonitor::pace() const {
  return shorter(pace_of(deadline_), pace_of(lease_));
}

}  // namespace sft::core
