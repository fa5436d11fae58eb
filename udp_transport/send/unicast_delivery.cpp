#include "udp_transport/send/unicast_delivery.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
}

void UnicastDelivery::prepare_for_channels(const Audience& audience, const core::SampleHandle& sample) {
  if (std::ranges::all_of(audience.channels, [](const auto& channel) { return channel == nullptr; })) return;
  const std::shared_ptr<core::BufferPool>& pool = side_->pool;
  if (job().is_small()) {
    if (!std::exchange(is_kept_, true) && !job().is_pack()) job().copy_body();
    return;
  }
  if (pool == nullptr || sample->owner == pool) return keep(sample);
  const std::size_t copy_bytes = std::max(job().projection.bytes(), sizeof(detail::SampleHeader));
  // If samples are borrowed, some reader may lag and need copies soon.
  if (jobs_->has_borrowed()) pool->expect(copy_bytes);
  if (jobs_->may_borrow(sample->capacity)) {
    keep(sample);
    return job().borrow();
  }
  core::SampleHandle copy = pool->take(copy_bytes, pool->limit_bytes() / 4);
  copy ? job().copy_body(std::move(copy)) : job().copy_body();
  is_kept_ = true;
}

std::size_t UnicastDelivery::send_once(const std::shared_ptr<Lane>& lane, const core::SampleHandle& sample) {
  const SendOutcome outcome = lane->is_clear() ? direct.send(*lane, job()) : SendOutcome::would_wait;
  if (outcome == SendOutcome::sent) return 0;
  if (outcome == SendOutcome::would_wait) {
    keep(sample);
    return enqueue(lane) == 0 ? 0 : job().samples();
  }
  lane->losses()->lost(job().first.total, job().whole_bytes, job().samples());
  return job().samples();
}

std::size_t UnicastDelivery::enqueue(const std::shared_ptr<Lane>& lane) {
  const Lane::Posted posted = lane->post(handle_);
  side_->sender.wake(posted.wake, lane);
  if (posted.dropped > 0) side_->over_limit.fetch_add(posted.dropped, std::memory_order_relaxed);
  return posted.dropped > 0 ? 1 : 0;
}

std::size_t UnicastDelivery::send_reliably(const std::shared_ptr<Lane>& lane,
                                           const std::shared_ptr<Channel>& channel) {
  const std::size_t job_samples = job().samples();
  if (lane->is_late() && (!lane->idle() || !channel->await_room(job(), nullptr))) {
    // The history of the late reader has to be sent first, and no sample of the history must be given up for
    // the job.
    if (timeout_.count() > 0) lane->await_room(job(), timeout_);
    return enqueue(lane);
  }
  if (lane->is_late()) lane->mark(job());
  const Clock::time_point now = Clock::now();
  const bool at_once = job().is_small() && direct.may_send(channel->destination(), job(), now);
  const Channel::Posted posted = channel->post(handle_, job().first, at_once, timeout());
  if (posted.piece)
    side_->sender.wake(direct.send(*channel, *posted.piece, posted.waited ? Clock::now() : now));
  return settle(posted, channel, *lane, job_samples);
}

std::size_t UnicastDelivery::settle(const Channel::Posted& posted, const std::shared_ptr<Channel>& channel,
                                    Lane& lane, std::size_t job_samples) {
  side_->sender.wake(posted.wake, channel);
  const ResendWindow::Kept& kept = posted.kept;
  lane.losses()->lost(kept.dropped_bytes, kept.dropped_whole_bytes, kept.dropped);
  side_->over_limit.fetch_add(kept.dropped, std::memory_order_relaxed);
  // If the publisher waits for its readers, sent samples that were given up without an ack count as lost,
  // too. They may have arrived, but they were not acknowledged while the publisher waited.
  const std::size_t gone = kept.dropped + (waits_for_readers_ ? kept.unacknowledged : 0);
  return std::min(gone, job_samples);
}

}  // namespace sft::udp
