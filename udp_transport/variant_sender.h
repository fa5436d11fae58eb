// Sends a writer's samples under one mask after the other: small ones at once, the rest through lanes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/transport.h"
#include "udp_transport/routes.h"
#include "udp_transport/send_side.h"

namespace sft::udp {

/// Larger bodies are sent by the sending thread: the publisher goes on after a few datagrams.
inline constexpr std::size_t direct_bytes_max = 16 * 1024;

/// Of one thread.
class VariantSender {
 public:
  VariantSender(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
                std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs);

  /// Returns how many destinations do not get it, or lose an older sample for it.
  std::size_t send(const Group& group, const core::SampleHandle& sample) noexcept;

  /// False if there is nothing to send: the sample is malformed, or too large. Any thread.
  bool encode(const Group& group, const core::SampleBuffer& sample, Job& job) const;

 private:
  void hold(const core::SampleHandle& sample);
  void release_blank();
  bool prepare(const Group& group, const core::SampleBuffer& sample);
  std::size_t send_alone(const Group& group, const core::SampleHandle& sample);
  bool send_alone(const Group& group, std::size_t place, const core::SampleHandle& sample);
  std::size_t send_together(const Group& group, const core::SampleHandle& sample);
  bool keep_together(const Group& group, std::size_t place, std::uint64_t ordinal, bool has_room);
  bool send_to_group(const Group& group, const core::SampleHandle& sample);
  bool note(const Channel::Posted& posted, const std::shared_ptr<Channel>& channel, Lane& lane);
  bool send_reliably(const std::shared_ptr<Lane>& lane, const std::shared_ptr<Channel>& channel,
                     const core::SampleHandle& sample);
  void send_now(Channel& channel, const Channel::Piece& piece);
  SendOutcome try_send(Lane& lane, Job& job);
  bool enqueue(const std::shared_ptr<Lane>& lane);

  const std::uint32_t writer_;  ///< low half of the id
  const TypeSupport& type_;
  const std::shared_ptr<SendSide> side_;
  const std::shared_ptr<WriterTally> tally_;
  const std::shared_ptr<JobPool> jobs_;

  JobHandle blank_;          ///< the next job, empty if a lane or a channel has the last
  bool blank_kept_ = false;  ///< by a channel
  Batch batch_;              ///< of the present sample
  std::size_t cut_for_ = 0;  ///< bytes of the datagrams in the batch; 0: none of the present sample
};

}  // namespace sft::udp
