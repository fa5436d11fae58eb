// Sends a writer's samples to one audience after another. Each sample is sent in the way that suits it and
// the audience.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

#include "core/seam/transport.h"
#include "udp_transport/outgoing/job.h"
#include "udp_transport/routing/routes.h"
#include "udp_transport/send/group_delivery.h"
#include "udp_transport/send/packer.h"
#include "udp_transport/send/postponed_delivery.h"
#include "udp_transport/send/sample_encoder.h"
#include "udp_transport/send/send_side.h"
#include "udp_transport/send/unicast_delivery.h"

namespace sft::udp {

/// An object must be used by only one thread, except for encode().
class VariantSender {
 public:
  VariantSender(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
                std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs);
  VariantSender(const VariantSender&) = delete;
  VariantSender& operator=(const VariantSender&) = delete;

  /// Sends the sample. Returns the number of destinations that do not get the sample, or lose an older one
  /// for it.
  std::size_t send(const Audience& audience, const core::SampleHandle& sample) noexcept;

  using Hold = Packer::Hold;
  /// Copies a small sample, so that flush() sends it in common datagrams with other samples. The audience
  /// must live until flush().
  Hold hold(const Audience& audience, const core::SampleHandle& sample) noexcept {
    return packer_.hold(audience, sample);
  }
  /// Sends the held samples. Returns the number of samples that some destination does not get, or for which
  /// it loses an older sample. Each sample counts only once, since the packs of all audiences have the same
  /// samples.
  std::size_t flush() noexcept;

  /// Sets the total time that the publisher may wait for acks, so that no reliable reader loses an older
  /// sample for a new one.
  void set_timeout(std::chrono::nanoseconds timeout) { unicast_.set_timeout(timeout); }
  void cap_timeout(std::chrono::nanoseconds timeout) { unicast_.cap_timeout(timeout); }

  /// Encodes the sample into the job. Returns false if the sample cannot be sent, because it is malformed or
  /// too large. Any thread may call this.
  bool encode(const Audience& audience, const core::SampleBuffer& sample, Job& job) const {
    return encoder_.encode(audience, sample, job);
  }

 private:
  std::size_t send_pack(const Packer::Pack& pack) noexcept;
  std::size_t distribute(const Audience& audience, const core::SampleHandle& sample);
  std::size_t send_body(const Audience& audience, const core::SampleHandle& sample,
                        const core::SampleHandle& body);
  std::size_t send_postponed(const Audience& audience, const core::SampleHandle& sample);

  const SampleEncoder encoder_;
  Packer packer_;
  UnicastDelivery unicast_;
  GroupDelivery group_;
  PostponedDelivery postponed_;
};

}  // namespace sft::udp
