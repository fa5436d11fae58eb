#include "udp_transport/outbox.h"

#include <algorithm>
#include <iterator>
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
    posted.was_idle = !scheduled_ && held_ == 0;
    scheduled_ |= posted.was_idle;
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

void Outbox::hold() {
  const std::scoped_lock lock(mutex_);
  ++held_;
  busy_.store(true, std::memory_order_relaxed);
}

bool Outbox::release(std::vector<std::unique_ptr<Job>> history) {
  tally_->history_waiting.fetch_add(history.size(), std::memory_order_relaxed);
  const std::scoped_lock lock(mutex_);
  // Behind what others are to be given: each is for one reader, so that among them the order does not matter.
  std::reverse(history.begin(), history.end());
  history_.insert(history_.begin(), std::make_move_iterator(history.begin()),
                  std::make_move_iterator(history.end()));
  --held_;
  const bool has_work = !history_.empty() || (held_ == 0 && !queue_.empty());
  const bool to_be_scheduled = has_work && !scheduled_;
  scheduled_ |= has_work;
  busy_.store(scheduled_ || held_ != 0, std::memory_order_release);
  return to_be_scheduled;
}

Job* Outbox::next() {
  const std::scoped_lock lock(mutex_);
  if (!history_.empty()) {
    current_ = std::move(history_.back());
    history_.pop_back();
    return current_.get();
  }
  if (queue_.empty() || held_ != 0) {
    scheduled_ = false;
    busy_.store(held_ != 0, std::memory_order_release);
    return nullptr;
  }
  current_ = std::move(queue_.front());
  queue_.erase(queue_.begin());
  return current_.get();
}

void Outbox::done() {
  if ((current_->first.flags & history_follows) != 0)
    tally_->history_waiting.fetch_sub(1, std::memory_order_relaxed);
  keep_spare(std::move(current_));
}

/// Releases the sample outside the lock.
void Outbox::keep_spare(std::unique_ptr<Job> job) {
  job->sample.reset();
  job->audience.reset();
  const std::scoped_lock lock(mutex_);
  if (spare_.size() < spare_.capacity()) spare_.push_back(std::move(job));
}

}  // namespace sft::udp
