#include "udp_transport/lane.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

Lane::Lane(std::shared_ptr<Destination> to, std::size_t depth, std::shared_ptr<WriterTally> tally)
    : to_(std::move(to)), depth_(std::max<std::size_t>(depth, 1)), tally_(std::move(tally)) {
  queue_.reserve(depth_);
}

Lane::Posted Lane::post(JobHandle job) {
  JobHandle oldest;  // goes outside the lock
  const std::scoped_lock lock(mutex_);
  if (closed()) return {};
  if (queue_.size() == depth_) {
    oldest = std::move(queue_.front());
    queue_.erase(queue_.begin());
  }
  queue_.push_back(std::move(job));
  return {.was_idle = !busy_.exchange(true, std::memory_order_relaxed),
          .dropped_oldest = static_cast<bool>(oldest)};
}

const Job* Lane::next() {
  current_ = {};
  const std::scoped_lock lock(mutex_);
  if (queue_.empty()) {
    busy_.store(false, std::memory_order_release);
    return nullptr;
  }
  current_ = std::move(queue_.front());
  queue_.erase(queue_.begin());
  return &*current_;
}

void Lane::close() {
  std::vector<JobHandle> dropped;  // goes outside the lock
  const std::scoped_lock lock(mutex_);
  closed_.store(true, std::memory_order_release);
  dropped.swap(queue_);
}

}  // namespace sft::udp
