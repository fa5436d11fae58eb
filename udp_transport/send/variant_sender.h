// Sends a writer's samples under one mask after another, in the way that suits each sample and audience.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

#include "core/seam/transport.h"
#include "udp_transport/outgoing/job.h"
#include "udp_transport/routing/routes.h"
#include "udp_transport/send/direct_path.h"
#include "udp_transport/send/draft.h"
#include "udp_transport/send/group_delivery.h"
#include "udp_transport/send/packer.h"
#include "udp_transport/send/postponed_delivery.h"
#include "udp_transport/send/sample_encoder.h"
#include "udp_transport/send/send_side.h"
#include "udp_transport/send/unicast_delivery.h"

namespace sft::udp {

/// An object is used by one thread only, except for encode().
class VariantSender {
 public:
  VariantSender(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
                std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs);
  VariantSender(const VariantSender&) = delete;
  VariantSender& operator=(const VariantSender&) = delete;

  /// Returns the number of destinations that do not get the sample, or lose an older one for it.
  std::size_t send(const Audience& audience, const core::SampleHandle& sample) noexcept;

  using Hold = Packer::Hold;
  /// Copies a small sample. flush() sends it in datagrams that it shares with other samples. The audience
  /// must live until flush().
  Hold hold(const Audience& audience, const core::SampleHandle& sample) noexcept {
    return packer_.hold(audience, sample);
  }
  /// Sends the held samples. Returns the number of samples that do not get to some destination, or made it
  /// lose an older one. Each sample counts once, since the packs of all audiences have the same samples.
  std::size_t flush() noexcept;

  /// Sets the time that the publisher may wait in all for room, so that a reliable sample makes no reader
  /// lose an older one.
  void set_timeout(std::chrono::nanoseconds timeout) { unicast_.reliable.set_timeout(timeout); }
  void cap_timeout(std::chrono::nanoseconds timeout) { unicast_.reliable.cap_timeout(timeout); }

  /// Returns false if there is nothing to send, because the sample is malformed or too large. Any thread
  /// may call this.
  bool encode(const Audience& audience, const core::SampleBuffer& sample, Job& job) const {
    return encoder_.encode(audience, sample, job);
  }

 private:
  std::size_t send_pack(const Packer::Pack& pack) noexcept;
  std::size_t distribute(const Audience& audience, const core::SampleHandle& sample);
  std::size_t send_body(const Audience& audience, const core::SampleHandle& sample,
                        const core::SampleHandle& body);
  std::size_t send_postponed(const Audience& audience, const core::SampleHandle& sample);

  const std::shared_ptr<SendSide> side_;
  const SampleEncoder encoder_;
  Packer packer_;
  Draft draft_;
  DirectPath direct_;
  UnicastDelivery unicast_;
  GroupDelivery group_;
  PostponedDelivery postponed_;
};

}  // namespace sft::udp
