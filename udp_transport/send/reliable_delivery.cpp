#include "udp_transport/send/reliable_delivery.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
}

/// Queues the job in the lane of a late reader. The history of that reader has to be sent first, and no
/// sample of the history must be given up for the job.
std::size_t ReliableDelivery::send_after_history(const std::shared_ptr<Lane>& lane) {
  if (draft_.job().is_small()) draft_.copy_for_channel();
  if (timeout_.count() > 0) lane->await_room(draft_.job(), timeout_);
  return best_effort_.enqueue(lane);
}

std::size_t ReliableDelivery::send(const std::shared_ptr<Lane>& lane,
                                   const std::shared_ptr<Channel>& channel) {
  Job& job = draft_.job();
  const std::size_t job_samples = job.samples();
  const bool small = job.is_small();
  if (lane->is_late() && (!lane->idle() || !channel->await_room(job, nullptr)))
    return send_after_history(lane);
  if (lane->is_late()) lane->mark(job);
  if (small) draft_.copy_for_channel();
  const Clock::time_point now = Clock::now();
  const bool at_once = small && direct_.may_send(channel->destination(), job, now);
  const Channel::Posted posted = channel->post(draft_.handle(), job.first, at_once, timeout());
  if (posted.piece)
    side_->sender.wake(direct_.send(*channel, *posted.piece, posted.waited ? Clock::now() : now));
  return settle(posted, channel, *lane, job_samples);
}

std::size_t ReliableDelivery::settle(const Channel::Posted& posted, const std::shared_ptr<Channel>& channel,
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
