#include "udp_transport/outbox.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

Outbox::Outbox(std::size_t depth, std::shared_ptr<WriterTally> tally)
    : depth_(std::max<std::size_t>(depth, 1)), tally_(std::move(tally)), blank_(std::make_unique<Job>()) {
  queue_.reserve(depth_);
  spare_.reserve(depth_ + 2);
}

Outbox::Posted Outbox::post() {
  Posted posted{};
  std::unique_ptr<Job> oldest;
  {
    const std::scoped_lock lock(mutex_);
    posted.was_idle = !busy_.load(std::memory_order_relaxed);
    if (queue_.size() == depth_) {
      oldest = std::move(queue_.front());
      queue_.erase(queue_.begin());
    }
    queue_.push_back(std::move(blank_));
    busy_.store(true, std::memory_order_relaxed);
    if (!spare_.empty()) {
      blank_ = std::move(spare_.back());
      spare_.pop_back();
    }
  }
  posted.dropped_oldest = oldest != nullptr;
  if (blank_ == nullptr) blank_ = oldest != nullptr ? std::move(oldest) : std::make_unique<Job>();
  if (oldest != nullptr) keep_spare(std::move(oldest));
  blank_->sample.reset();
  blank_->audience.reset();
  return posted;
}

Job* Outbox::next() {
  const std::scoped_lock lock(mutex_);
  if (queue_.empty()) {
    busy_.store(false, std::memory_order_release);
    return nullptr;
  }
  current_ = std::move(queue_.front());
  queue_.erase(queue_.begin());
  return current_.get();
}

void Outbox::done() { keep_spare(std::move(current_)); }

/// Releases the sample outside the lock.
void Outbox::keep_spare(std::unique_ptr<Job> job) {
  job->sample.reset();
  job->audience.reset();
  const std::scoped_lock lock(mutex_);
  spare_.push_back(std::move(job));
}

}  // namespace sft::udp
