#include "udp_transport/lane.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace sft::udp {

namespace {
bool is_retained(const Job& job) { return (job.first.flags & history_follows) != 0; }
}  // namespace

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
    count_lost(*oldest);
  }
  queue_.push_back(std::move(job));
  busy_.store(true, std::memory_order_relaxed);
  return {.was_idle = held_ == 0 && !std::exchange(scheduled_, true),
          .dropped_oldest = static_cast<bool>(oldest)};
}

void Lane::lose_current() {
  tally_->dropped.fetch_add(1, std::memory_order_relaxed);
  if (!is_retained(*current_)) count_lost(*current_);
}

void Lane::count_lost(const Job& job) const {
  losses_->lost(job.first.total, job.sample ? job.sample->whole_bytes : 0);
}

void Lane::hold() {
  const std::scoped_lock lock(mutex_);
  ++held_;
  busy_.store(true, std::memory_order_relaxed);
}

bool Lane::release(std::vector<JobHandle> history) {
  const std::scoped_lock lock(mutex_);
  --held_;
  if (closed()) return false;
  tally_->history_waiting.fetch_add(history.size(), std::memory_order_relaxed);
  // Behind what others are to be given: each is for one reader, so that among them the order does not matter.
  history_.insert(history_.begin(), std::make_move_iterator(history.rbegin()),
                  std::make_move_iterator(history.rend()));
  const bool has_work = !history_.empty() || (held_ == 0 && !queue_.empty());
  const bool is_new = has_work && !std::exchange(scheduled_, true);
  busy_.store(scheduled_ || held_ != 0, std::memory_order_release);
  return is_new;
}

const Job* Lane::next() {
  if (current_ && is_retained(*current_)) tally_->history_waiting.fetch_sub(1, std::memory_order_relaxed);
  current_ = {};
  const std::scoped_lock lock(mutex_);
  if (!history_.empty()) {
    current_ = std::move(history_.back());
    history_.pop_back();
    return &*current_;
  }
  if (queue_.empty() || held_ != 0) {
    scheduled_ = false;
    busy_.store(held_ != 0, std::memory_order_release);
    return nullptr;
  }
  current_ = std::move(queue_.front());
  queue_.erase(queue_.begin());
  return &*current_;
}

void Lane::close() {
  std::vector<JobHandle> dropped, dropped_history;  // go outside the lock
  const std::scoped_lock lock(mutex_);
  closed_.store(true, std::memory_order_release);
  dropped.swap(queue_);
  dropped_history.swap(history_);
  tally_->history_waiting.fetch_sub(dropped_history.size(), std::memory_order_relaxed);
}

}  // namespace sft::udp
