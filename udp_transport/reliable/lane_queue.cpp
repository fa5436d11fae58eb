#include "udp_transport/reliable/lane_queue.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

LaneQueue::LaneQueue(std::size_t depth, const Limits& beyond_depth)
    : depth_(std::max<std::size_t>(depth, 1)), beyond_depth_(beyond_depth) {
  posted_.reserve(depth_);
}

void LaneQueue::post(JobHandle job) {
  if (first_sequence_ == 0) first_sequence_ = job->sequence;
  posted_bytes_ += job->held_bytes_in_all();
  posted_.push_back(std::move(job));
}

JobHandle LaneQueue::pop_oldest() {
  JobHandle oldest = std::move(posted_[posted_.begin()]);
  posted_.pop_front();
  posted_bytes_ -= oldest->held_bytes_in_all();
  return oldest;
}

void LaneQueue::put_first(std::vector<JobHandle> retained) {
  std::ranges::reverse(retained);
  retained_ = std::move(retained);
  if (!retained_.empty()) first_sequence_ = retained_.back()->sequence;
}

LaneQueue::Next LaneQueue::take() {
  Next next{.is_retained = !retained_.empty()};
  if (next.is_retained) {
    next.job = std::move(retained_.back());
    retained_.pop_back();
  } else if (!posted_.empty()) {
    next.job = pop_oldest();
  }
  if (next.job && (next.job->first.flags & history_follows) != 0)
    next.job->first.history.oldest = first_sequence_;
  return next;
}

void LaneQueue::mark(Job& job) {
  if (first_sequence_ == 0) first_sequence_ = job.sequence;
  job.first.history.oldest = first_sequence_;
}

LaneQueue::Contents LaneQueue::clear() {
  posted_bytes_ = 0;
  return {.posted = std::exchange(posted_, OrdinalRing<JobHandle>{0}),
          .retained = std::exchange(retained_, {})};
}

}  // namespace sft::udp
