// Where the samples of a lane go: to one destination, or by a destination that is a multicast group to its
// members.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <utility>

#include "udp_transport/flow/destination.h"
#include "udp_transport/outgoing/job.h"

namespace sft::udp {

/// A listener is told of each job that a lane is done with. It calls nothing of the lane.
class LaneListener {
 public:
  virtual ~LaneListener() = default;
  /// Any thread. `lost`: the job was not sent, or not all of it.
  virtual void departed(const Job& job, bool lost) noexcept = 0;
  /// Any thread. What goes through the lane comes to these instead of the lane's own destination; always the
  /// same ones, as long as the listener is there.
  virtual std::span<const Destination* const> receivers() const noexcept = 0;
};

/// Any thread, but for notify().
class LaneEnd {
 public:
  explicit LaneEnd(std::shared_ptr<Destination> to) : to_(std::move(to)) {}

  /// The lane leads to a group. Called before anything else.
  void notify(std::weak_ptr<LaneListener> group) {
    group_ = std::move(group);
    is_group_ = true;
  }

  Destination& destination() const { return *to_; }
  bool is_group() const { return is_group_; }
  /// Sets whether the readers at the destination share what comes from now on, whatever their masks are.
  void set_shared(bool shared) { is_shared_.store(shared, std::memory_order_relaxed); }
  /// True if samples for this end are for readers with different masks. Each mask may have a lane of its own
  /// before that, or afterwards.
  bool is_merged() const { return is_group_ || is_shared_.load(std::memory_order_relaxed); }
  /// Returns whether samples for both ends come to the same receiver, and some of them are merged: then the
  /// order has to be kept between the lanes.
  bool meets_merged(const LaneEnd& other) const;
  /// The lane is done with the job, if there is one.
  void departed(const JobHandle& job, bool lost) const;

 private:
  const std::shared_ptr<Destination> to_;
  std::weak_ptr<LaneListener> group_;
  bool is_group_ = false;
  std::atomic<bool> is_shared_{false};
};

}  // namespace sft::udp
