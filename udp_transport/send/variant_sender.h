// Sends a writer's samples under one mask after the other: small ones at once, large ones too where that
// saves a copy, the rest through lanes.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/seam/transport.h"
#include "udp_transport/outgoing/job.h"
#include "udp_transport/routing/routes.h"
#include "udp_transport/send/send_side.h"

namespace sft::udp {

/// Of one thread.
class VariantSender {
 public:
  VariantSender(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
                std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs);

  /// Returns how many destinations do not get it, or lose an older sample for it.
  std::size_t send(const Group& group, const core::SampleHandle& sample) noexcept;

  enum class Hold : std::uint8_t {
    held,
    full,   ///< it has to wait for flush()
    unfit,  ///< it is not small, or must not be: flush(), and then send() it
  };
  /// Copies a small sample, to be sent by flush() in datagrams that it shares with others. The group lives
  /// until then.
  Hold hold(const Group& group, const core::SampleHandle& sample) noexcept;
  /// Returns how many samples do not get to some destination, or cost it an older one: each counts once,
  /// for what is held is held for all.
  std::size_t flush() noexcept;

  /// So long, in all, it may wait from now on until what is sent reliably costs nobody an older sample.
  void be_patient(std::chrono::nanoseconds patience) { patience_ = patience; }
  void be_no_more_patient_than(std::chrono::nanoseconds patience) {
    patience_ = std::min(patience_, patience);
  }

  /// False if there is nothing to send: the sample is malformed, or too large. Any thread.
  bool encode(const Group& group, const core::SampleBuffer& sample, Job& job) const;

 private:
  struct Held {
    const Group* group;
    JobHandle pack;
    std::size_t sample_bytes_max;
    std::size_t pack_bytes_max;
    bool follows(const core::SampleBuffer& sample, std::size_t bytes) const;
  };
  Held& held_for(const Group& group);
  std::size_t send_pack(const Held& held) noexcept;
  void keep_for_later(const core::SampleHandle& sample);
  void keep_in_channels(const core::SampleHandle& sample);
  void release_blank();
  std::size_t distribute(const Group& group, const core::SampleHandle& sample);
  bool goes_ahead(const Group& group) const;
  std::size_t send_ahead(const Group& group, const core::SampleHandle& sample);
  std::size_t send_ahead_once(const std::shared_ptr<Lane>& lane, const core::SampleHandle& sample);
  std::optional<std::size_t> send_ahead_reliably(Lane& lane, const std::shared_ptr<Channel>& channel,
                                                 const core::SampleHandle& sample);
  std::uint32_t send_located(const FirstHeader& first, Destination& to);
  std::size_t send_alone(const Group& group, std::size_t place, const core::SampleHandle& sample);
  std::size_t send_together(const Group& group, const core::SampleHandle& sample);
  std::size_t send_to_the_deaf(const Group& group, const core::SampleHandle& sample);
  std::size_t keep_together(const Group& group, std::size_t place, std::uint64_t ordinal, bool has_room);
  bool send_to_group(const Group& group, const core::SampleHandle& sample);
  std::size_t note(const Channel::Posted& posted, const std::shared_ptr<Channel>& channel, Lane& lane,
                   std::size_t job_samples);
  std::size_t send_after_history(const std::shared_ptr<Lane>& lane);
  std::size_t send_reliably(const std::shared_ptr<Lane>& lane, const std::shared_ptr<Channel>& channel);
  bool may_send_now(Destination& to, const Job& job, std::chrono::steady_clock::time_point now);
  SendOutcome send_batch(Destination& to, Connection& by, std::size_t cut_for,
                         std::chrono::steady_clock::time_point now);
  void send_now(Channel& channel, const Channel::Piece& piece, std::chrono::steady_clock::time_point now);
  SendOutcome try_send(Lane& lane, Job& job);
  SendOutcome send_at_once(const EncodedBody& body, Destination& to, Connection& by,
                           std::chrono::steady_clock::time_point now);
  void describe(const Group& group, const core::SampleBuffer& sample, Job& job) const;
  bool enqueue(const std::shared_ptr<Lane>& lane);

  const std::uint32_t writer_;  ///< low half of the id
  const bool waits_for_readers_;
  const TypeSupport& type_;
  const std::shared_ptr<SendSide> side_;
  const std::shared_ptr<WriterTally> tally_;
  const std::shared_ptr<JobPool> jobs_;

  JobHandle blank_;          ///< the next job, empty if a lane or a channel has the last
  bool blank_kept_ = false;  ///< by a channel
  Batch batch_;              ///< of the present sample
  std::size_t cut_for_ = 0;  ///< bytes of the datagrams in the batch; 0: none of the present sample
  std::chrono::nanoseconds patience_{0};
  std::vector<detail::Segment> located_;  ///< where the present body is
  JobHandle projected_;                   ///< what is to be held next
  std::vector<Held> held_;
};

}  // namespace sft::udp
