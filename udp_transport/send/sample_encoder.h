// Encodes a writer's samples for an audience: the body with the mask of the audience, and the header of the
// first datagram.
#pragma once

#include <cstdint>
#include <memory>

#include "core/seam/transport.h"
#include "udp_transport/outgoing/job.h"
#include "udp_transport/routing/routes.h"
#include "udp_transport/send/send_side.h"

namespace sft::udp {

/// Any thread may call the functions, except for number().
class SampleEncoder {
 public:
  SampleEncoder(const core::WriterSpec& spec, std::shared_ptr<SendSide> side)
      : writer_(static_cast<std::uint32_t>(spec.id)), type_(*spec.type), side_(std::move(side)) {}

  /// Encodes the sample into the job. Returns false if the sample cannot be sent, because it is malformed or
  /// too large. If large parts of fields were requested, the body is in the node's own memory, and the
  /// sample of the job is that memory.
  bool encode(const Audience& audience, const core::SampleBuffer& sample, Job& job) const;
  /// If the audience has a gate, writes the number of the sample among those that passed the gate. Must be
  /// called by the publisher's thread, and only if the sample has passed. Retained samples pass no gate.
  static void number(const Audience& audience, Job& job);
  /// Writes all fields of the job's header, except the length of the body.
  void describe(const Audience& audience, const core::SampleBuffer& sample, Job& job) const;
  /// Projects the sample to the mask of the audience. Returns false if the sample is malformed.
  bool project(const Audience& audience, const core::SampleBuffer& sample, detail::Projection& body) const {
    return body.project(core::state_of(sample, type_.index_slots()), audience.plan);
  }

 private:
  bool gather(const Audience& audience, const core::SampleBuffer& sample, Job& job) const;

  const std::uint32_t writer_;  ///< low half of the writer's id
  const TypeSupport& type_;
  const std::shared_ptr<SendSide> side_;
};

}  // namespace sft::udp
