#include "udp_transport/send/best_effort_delivery.h"

namespace sft::udp {

std::size_t BestEffortDelivery::send(const std::shared_ptr<Lane>& lane, const core::SampleHandle& sample) {
  Job& job = draft_.job();
  const SendOutcome outcome = lane->is_clear() ? direct_.send(*lane, job) : SendOutcome::would_wait;
  if (outcome == SendOutcome::sent) return 0;
  if (outcome == SendOutcome::would_wait) {
    draft_.keep(sample);
    return enqueue(lane) == 0 ? 0 : job.samples();
  }
  lane->losses()->lost(job.first.total, job.whole_bytes, job.samples());
  return job.samples();
}

std::size_t BestEffortDelivery::enqueue(const std::shared_ptr<Lane>& lane) {
  const Lane::Posted posted = lane->post(draft_.handle());
  side_->sender.wake(posted.wake, lane);
  if (posted.dropped > 0) side_->over_limit.fetch_add(posted.dropped, std::memory_order_relaxed);
  return posted.dropped > 0 ? 1 : 0;
}

}  // namespace sft::udp
