#include "udp_transport/outgoing/job.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <new>

#include "core/seam/buffer_pool.h"

namespace sft::udp {

JobHandle::~JobHandle() {
  if (job_ == nullptr || job_->references_.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
  const std::shared_ptr<JobPool> pool = std::move(job_->pool_);  // this may be the pool's last reference
  pool->recycle(std::unique_ptr<Job>(job_));
}

void Job::copy_body() {
  copy_.reserve(projection.bytes());
  copy_.clear();
  for (const detail::Segment& segment : projection.segments())
    copy_.insert(copy_.end(), segment.data, segment.data + segment.bytes);
  copied_ = {copy_.data(), copy_.size()};
}

void Job::copy_body(core::SampleHandle to) {
  std::byte* at = to->data;
  for (const detail::Segment& segment : projection.segments())
    at = std::copy_n(segment.data, segment.bytes, at);
  copied_ = {to->data, projection.bytes()};
  sample = std::move(to);
}

void Job::borrow() {
  borrowed_bytes_ = sample->capacity;
  pool_->borrowed_samples_.fetch_add(1, std::memory_order_relaxed);
  pool_->borrowed_bytes_.fetch_add(borrowed_bytes_, std::memory_order_relaxed);
}

void Job::keep() {
  if (kept_bytes_ != 0) return;
  kept_bytes_ = held_bytes_in_all();
  pool_->memory_->add(kept_bytes_);
}

void Job::pack(std::span<const detail::Segment> body) {
  std::size_t bytes = 0;
  for (const detail::Segment& segment : body) bytes += segment.bytes;
  copy_.resize(packed_bytes_ + bytes);
  packed_.push_back({nullptr, bytes});
  std::byte* to = copy_.data() + packed_bytes_;
  for (const detail::Segment& segment : body) to = std::copy_n(segment.data, segment.bytes, to);
  packed_bytes_ += bytes;
}

void Job::seal() {
  const std::byte* at = copy_.data();
  for (detail::Segment& body : packed_) {
    body.data = at;
    at += body.bytes;
  }
  first.total = static_cast<std::uint32_t>(packed_bytes_);
}

JobHandle JobPool::take() {
  std::unique_ptr<Job> job;
  {
    const core::Lock lock(mutex_);
    if (!spare_.empty()) {
      job = std::move(spare_.back());
      spare_.pop_back();
      unneeded_ = std::min(unneeded_, spare_.size());
    } else {
      if (spare_.capacity() <= jobs_) spare_.reserve(std::min(2 * jobs_ + 1, spare_max));
      job = std::make_unique<Job>();
      ++jobs_;
      widen(*job);
    }
  }
  job->pool_ = shared_from_this();
  return JobHandle(job.release());
}

/// Gives all spare jobs as much memory as this job has, because any job may be used next for any mask. If
/// each job grew only when it was used, memory would be allocated until each job had been used for each
/// mask. With this function, no job allocates any more after a few samples. A job in use grows when it
/// returns to the pool.
void JobPool::widen(Job& job) noexcept try {
  const detail::Projection::Memory own = job.projection.memory();
  const bool is_wider = !widest_.suffices_for(own);
  widest_ = {std::max(widest_.staging_bytes, own.staging_bytes), std::max(widest_.segments, own.segments)};
  if (jobs_ * widest_.bytes() > projections_bytes_max) return;
  if (!own.suffices_for(widest_)) job.projection.reserve(widest_);
  if (!is_wider) return;
  for (const std::unique_ptr<Job>& spare : spare_) spare->projection.reserve(widest_);
} catch (const std::bad_alloc&) {  // such a job grows when it is used
}

void JobPool::recycle(std::unique_ptr<Job> job) noexcept {
  job->sample.reset();
  job->mask.reset();
  job->copy_.clear();
  if (job->copy_.capacity() > spare_copy_bytes_max) job->copy_.shrink_to_fit();
  job->copied_ = {};
  job->sent_bytes = 0;
  memory_->remove(std::exchange(job->kept_bytes_, 0));
  if (const std::size_t bytes = std::exchange(job->borrowed_bytes_, 0); bytes != 0) {
    borrowed_samples_.fetch_sub(1, std::memory_order_relaxed);
    borrowed_bytes_.fetch_sub(bytes, std::memory_order_relaxed);
  }
  job->packed_.clear();
  job->packed_bytes_ = 0;
  const core::Lock lock(mutex_);
  widen(*job);
  if (spare_.size() < spare_max) {
    spare_.push_back(std::move(job));
  } else {
    --jobs_;
  }
}

/// The jobs that have been spare for the longest time are at the front. After a peak, the next jobs say how
/// much memory a projection needs.
void JobPool::give_back(core::Time now) {
  std::vector<std::unique_ptr<Job>> unneeded;  // destroyed without the lock
  const core::Lock lock(mutex_);
  if (now < period_ends_) return;
  period_ends_ = now + core::BufferPool::period;
  const auto end = spare_.begin() + static_cast<std::ptrdiff_t>(unneeded_);
  unneeded.assign(std::move_iterator(spare_.begin()), std::move_iterator(end));
  spare_.erase(spare_.begin(), end);
  jobs_ -= unneeded.size();
  unneeded_ = spare_.size();
  if (!unneeded.empty()) widest_ = {};
}

}  // namespace sft::udp
