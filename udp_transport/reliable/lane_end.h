// The target of a lane's samples: one destination, or the members of a multicast group. For a group, the
// destination has the address of the group.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <utility>

#include "udp_transport/flow/destination.h"
#include "udp_transport/outgoing/job.h"

namespace sft::udp {

/// Is notified when a lane has sent or dropped a job. An implementation must not call functions of the lane.
class LaneListener {
 public:
  virtual ~LaneListener() = default;
  /// Called by any thread. `lost` is true if the job was not sent completely.
  virtual void departed(const Job& job, bool lost) noexcept = 0;
  /// Returns the destinations of all members of the group to which the lane sends. The receivers do not
  /// change during the life of the listener. Any thread may call this.
  virtual std::span<const Destination* const> receivers() const noexcept = 0;
};

/// Any thread may call the functions, except for notify().
class LaneEnd {
 public:
  explicit LaneEnd(std::shared_ptr<Destination> to) : to_(std::move(to)) {}

  /// Makes the lane send to a multicast group, and notifies that group. Must be called before any other
  /// function.
  void notify(std::weak_ptr<LaneListener> group) {
    group_ = std::move(group);
    is_group_ = true;
  }

  Destination& destination() const { return *to_; }
  bool is_group() const { return is_group_; }
  /// Sets whether all readers at the destination share one copy of each further sample, whatever their masks
  /// are.
  void set_shared(bool shared) { is_shared_.store(shared, std::memory_order_relaxed); }
  /// Returns true if a sample for this end may be for readers with different masks. If it is false, each
  /// mask may have its own lane.
  bool is_merged() const { return is_group_ || is_shared_.load(std::memory_order_relaxed); }
  /// Returns true if both ends have a receiver in common, and one of them is merged. Then the order of
  /// samples between the two lanes has to be kept.
  bool meets_merged(const LaneEnd& other) const;
  /// Notifies the group, if there is one, that the lane has sent or dropped the job. A null job is ignored.
  void departed(const JobHandle& job, bool lost) const;

 private:
  const std::shared_ptr<Destination> to_;
  std::weak_ptr<LaneListener> group_;
  bool is_group_ = false;
  std::atomic<bool> is_shared_{false};
};

}  // namespace sft::udp
