#include "udp_transport/send/variant_sender.h"

#include <algorithm>
#include <new>
#include <utility>

namespace sft::udp {

VariantSender::VariantSender(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
                             std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs)
    : encoder_(spec, side),
      packer_(side, encoder_, jobs),
      unicast_(side, std::move(tally), std::move(jobs), spec.max_blocking.count() > 0),
      group_(std::move(side), encoder_, unicast_),
      postponed_(unicast_) {}

std::size_t VariantSender::send(const Audience& audience, const core::SampleHandle& sample) noexcept try {
  Job& job = unicast_.begin();
  if (!encoder_.encode(audience, *sample, job)) {
    audience.tally->dropped();
    return audience.lanes.size();
  }
  SampleEncoder::number(audience, job);
  if (job.sample) return send_body(audience, sample, std::exchange(job.sample, {}));
  if (sample->postponed != nullptr && !job.is_small()) {
    if (PostponedDelivery::is_possible(audience)) return send_postponed(audience, sample);
    sample->complete();
  }
  return send_body(audience, sample, sample);
  // An allocation can fail here, because buffers grow with the samples that they hold.
} catch (const std::bad_alloc&) {
  audience.tally->dropped();
  unicast_.reset();
  return audience.lanes.size();
}

/// Sends a sample. `body` has the bytes of the job's body: it is the sample itself, or memory with the
/// requested parts of the sample.
std::size_t VariantSender::send_body(const Audience& audience, const core::SampleHandle& sample,
                                     const core::SampleHandle& body) {
  return audience.multicast == nullptr ? distribute(audience, body) : group_.send(audience, sample, body);
}

std::size_t VariantSender::send_postponed(const Audience& audience, const core::SampleHandle& sample) {
  const std::optional<std::size_t> missed = postponed_.send(audience, sample);
  if (!missed) {
    sample->complete();
    return distribute(audience, sample);
  }
  audience.tally->sent(unicast_.job().first.total, unicast_.job().whole_bytes, 1);
  unicast_.release();
  return *missed;
}

/// Sends the job to each destination separately. Returns the number of missed samples of all destinations
/// together; for a pack the greatest number of one destination, since usually all destinations miss the same
/// samples. Data that channels keep is copied first, because the sending thread may read the job as soon as
/// a lane has it.
std::size_t VariantSender::distribute(const Audience& audience, const core::SampleHandle& sample) {
  Job& job = unicast_.job();
  unicast_.direct.begin_sample();
  std::size_t missed = 0;
  unicast_.prepare_for_channels(audience, sample);
  for (std::size_t i = 0; i < audience.lanes.size(); ++i) {
    const std::size_t here = unicast_.send(audience, i, sample);
    missed = job.is_pack() ? std::max(missed, here) : missed + here;
  }
  audience.tally->sent(job.first.total, job.whole_bytes, job.samples());
  unicast_.release();
  return missed;
}

std::size_t VariantSender::flush() noexcept {
  std::size_t missed = 0;
  packer_.take_packs([&](const Packer::Pack& pack) { missed = std::max(missed, send_pack(pack)); });
  return missed;
}

std::size_t VariantSender::send_pack(const Packer::Pack& pack) noexcept try {
  pack.job->seal();
  JobHandle before = unicast_.exchange(pack.job);
  const std::size_t missed = distribute(*pack.audience, {});
  unicast_.exchange(std::move(before));
  return missed;
} catch (const std::bad_alloc&) {
  for (std::size_t i = 0; i < pack.job->samples(); ++i) pack.audience->tally->dropped();
  unicast_.reset();
  return pack.job->samples();
}

}  // namespace sft::udp
