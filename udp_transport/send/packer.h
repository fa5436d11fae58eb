// Packs small samples that are published together into common datagrams.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/seam/sample_buffer.h"
#include "udp_transport/outgoing/job.h"
#include "udp_transport/routing/routes.h"
#include "udp_transport/send/sample_encoder.h"

namespace sft::udp {

/// An object must be used by only one thread.
class Packer {
 public:
  /// `encoder` must outlive this object. Samples longer than SendSide::max_sample_bytes are not packed.
  Packer(std::shared_ptr<SendSide> side, const SampleEncoder& encoder, std::shared_ptr<JobPool> jobs)
      : side_(std::move(side)), encoder_(encoder), jobs_(std::move(jobs)) {}

  enum class Hold : std::uint8_t {
    held,
    full,   ///< the packs have to be sent before the sample can be held
    unfit,  ///< the sample is too large or must not be packed; the caller sends it alone, after the packs
  };
  /// Copies a small sample into the pack of the audience. The audience must live until the packs are taken.
  Hold hold(const Audience& audience, const core::SampleHandle& sample) noexcept;

  /// A pack that is ready to be sent.
  struct Pack {
    const Audience* audience;
    JobHandle job;
    std::size_t sample_bytes_max;
    std::size_t pack_bytes_max;
    bool takes(const core::SampleBuffer& sample, std::size_t bytes) const;
  };
  /// Calls `send(pack)` for each pack that is not empty, and removes all packs.
  template <class Send>
  void take_packs(const Send& send) noexcept {
    for (const Pack& pack : packs_) {
      if (pack.job->is_pack()) send(pack);
    }
    packs_.clear();
  }

 private:
  Pack& pack_for(const Audience& audience);

  const std::shared_ptr<SendSide> side_;
  const SampleEncoder& encoder_;
  const std::shared_ptr<JobPool> jobs_;
  JobHandle projected_;  ///< job for the projection of the sample that is being packed
  std::vector<Pack> packs_;
};

}  // namespace sft::udp
