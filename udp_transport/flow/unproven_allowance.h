// Limits the datagrams that may be sent to a receiver before its first report: a few small datagrams and flow
// marks (requests for a report), and no more than the rest of its host's budget. So a forged announcement
// cannot make this host flood another one.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <utility>

#include "udp_transport/flow/flow_limits.h"
#include "udp_transport/flow/unproven_budget.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class UnprovenAllowance {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `host` limits what is sent to all receivers on that host together before they answer; null: only the
  /// limits of this receiver count.
  UnprovenAllowance(const FlowLimits& limits, std::shared_ptr<UnprovenBudget> host)
      : bytes_max_(limits.unproven_bytes),
        datagrams_max_(limits.unproven_datagrams),
        marks_max_(limits.unproven_marks),
        host_(std::move(host)) {}

  std::size_t datagrams_left(Time now) const {
    const std::size_t left = datagrams_max_ - std::min(datagrams_max_, datagrams_);
    return left == 0 || host_ == nullptr ? left : std::min(left, host_->left(now));
  }
  std::size_t bytes_left(Time now) const {
    if (bytes_ >= bytes_max_) return 0;
    return std::min(bytes_max_ - bytes_, datagrams_left(now) * datagram_bytes_min);
  }
  void spend(std::size_t bytes, std::size_t datagrams, Time now) {
    bytes_ += bytes;
    datagrams_ += datagrams;
    if (host_ != nullptr) host_->spend(datagrams, now);
  }
  /// Returns true if a flow mark may be sent, and then counts the mark. The receiver's own allowance is used
  /// first, and then the budget of its host.
  bool takes_mark(Time now) { return marks_++ < marks_max_ || host_ == nullptr || host_->takes_mark(now); }
  /// Notes that the receiver has reported. Its datagrams are then returned to the host's budget, since the
  /// receiver wanted them.
  void proven() {
    if (host_ != nullptr) host_->give_back(datagrams_);
  }
  /// Notes that a report has come from the host.
  void answered(Time now) {
    if (host_ != nullptr) host_->answered(now);
  }
  /// Resets the allowance for another address of the receiver. The receiver has to answer at that address
  /// first.
  void begin_anew(std::shared_ptr<UnprovenBudget> host) {
    host_ = std::move(host);
    bytes_ = datagrams_ = marks_ = 0;
  }

 private:
  std::size_t bytes_max_;
  std::size_t datagrams_max_;
  std::size_t marks_max_;
  std::shared_ptr<UnprovenBudget> host_;
  std::size_t bytes_ = 0;
  std::size_t datagrams_ = 0;
  std::size_t marks_ = 0;
};

}  // namespace sft::udp
