// The writer's end of a channel (wire_format.md). It keeps samples that were sent to one process until that
// process has acknowledged them, and decides if a sample, a repair or a heartbeat is sent next. Uses no
// clock, thread or I/O: events and times are passed in, decisions are returned.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "udp_transport/outgoing/job.h"
#include "udp_transport/outgoing/kept_memory.h"
#include "udp_transport/outgoing/resend_limits.h"
#include "udp_transport/reliable/heartbeat_schedule.h"
#include "udp_transport/reliable/kept_samples.h"
#include "udp_transport/reliable/repair_queue.h"
#include "udp_transport/wire/datagram.h"
#include "udp_transport/wire/fragmenter.h"

namespace sft::udp {

class ResendWindow {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Size = KeptSamples::Size;
  using Kept = KeptSamples::Kept;

  /// A sample to be sent, or a part of a sample to be sent again.
  struct Piece {
    FirstHeader first;
    JobHandle job;
    BodyRange range{};
    std::uint64_t ordinal = 0;
    bool is_repair = false;
    std::uint32_t part = 0;  ///< index of the first sample to send in its pack
    std::uint32_t samples = 1;
    EncodedBody body() const { return job->body(first, part, samples); }
  };

  /// `memory` counts the memory that all channels keep.
  ResendWindow(std::uint32_t writer, std::uint32_t channel, const ResendLimits& limits,
               std::uint64_t first_ordinal = 1, std::shared_ptr<const KeptMemory> memory = {});

  /// Keeps a sample, or each sample of a pack, and gives it the next ordinal of the channel. `ordinal` of
  /// the result is that of the first kept sample. The job must not change any more; `first` is its header.
  /// If `elsewhere` is true (never for packs), a multicast group sends the sample, and this channel only
  /// repairs it. But if more than half of a limit is in use, this channel sends the sample, too.
  Kept keep(JobHandle job, FirstHeader first, bool elsewhere = false);
  /// Notes that the multicast group has sent the sample with this ordinal.
  void departed(std::uint64_t ordinal, Time now);

  /// Returns the piece that may be sent now. The piece counts as being sent until finished() or put_back()
  /// is called.
  std::optional<Piece> next(Size size, Time now);
  /// Returns the sample with this ordinal as next() does, if it is the next sample to be sent.
  std::optional<Piece> take(std::uint64_t ordinal);
  void finished(const Piece& piece, Time now);
  /// Puts the piece back, so that its range is sent later.
  void put_back(const Piece& piece);
  /// Returns true if no sample waits to be sent or is under way for the first time.
  bool all_sent() const { return kept_.sent_end() == kept_.end(); }
  bool keeps(std::uint64_t ordinal) const { return kept_.contains(ordinal); }

  /// Returns the job of a sample that a multicast group has sent; null for other samples. The job has the
  /// header that the group used.
  JobHandle sent_elsewhere(std::uint64_t ordinal) const;

  /// Processes an ack. An implausible ack is ignored. An ack of another channel of the writer shows that the
  /// receiver may follow a wrong channel. Then samples carry the full number of this channel, and a
  /// heartbeat is due at once. A part that was sent again less than `round_trip` ago is still under way, and
  /// is not sent once more.
  void hear(const Ack& ack, Time now, Time::duration round_trip = {});
  /// Returns true if the receiver has acknowledged samples that were never sent. Only a fault can cause
  /// that, so its acks for this channel are ignored from then on.
  bool gone_wrong() const { return impossible_ >= impossible_max; }

  /// Notes that the path has changed. A heartbeat is due at once, because it also gives the receiver the
  /// new address for acks.
  void way_changed(Time now) { heartbeats_.way_changed(kept_.amount(), now); }

  /// Returns a heartbeat if one is due. The caller sets its port.
  std::optional<Heartbeat> heartbeat(Time now);
  /// Returns the last heartbeat of a channel that ends. It reports an empty range of kept samples, so that
  /// the receiver waits for no sample any more.
  Heartbeat parting() const;

  /// Returns the time of the next check if no event is noted before; Time::max() if no check is needed.
  Time next_look(Time now) const;
  /// Returns true if `samples` samples with `bytes` bytes can be kept without giving up older ones.
  bool can_keep(std::size_t samples, std::size_t bytes) const { return kept_.can_keep(samples, bytes); }
  /// Returns true if no sample is kept, so that none has to be sent or acknowledged.
  bool settled() const { return kept_.size() == 0; }

  /// Returns the size of the sample's body in bytes. Returns nothing if the sample was not sent or is not
  /// kept any more.
  std::optional<std::uint32_t> bytes_sent(std::uint64_t ordinal) const;
  /// The channel keeps the samples with ordinals in [begin(), end()).
  std::uint64_t begin() const { return kept_.begin(); }
  std::uint64_t end() const { return kept_.end(); }

  /// Returns true if a sample or a repair waits to be sent.
  bool has_work();

  std::size_t kept() const { return kept_.size(); }
  std::size_t kept_bytes() const { return kept_.bytes(); }
  std::uint64_t repairs() const { return repairs_.sent(); }  ///< number of parts that were sent again

 private:
  Piece piece_of(std::uint64_t ordinal) const;
  std::optional<Piece> next_repair(Size size, Time now);
  std::optional<Piece> next_sample(Size size);
  Piece begin_sample(std::uint64_t ordinal);
  void ask_for(const Missing& part, std::uint64_t next, Time now);

  /// If this number of acks in a row are about samples that were never sent, the channel has gone wrong. A
  /// single such ack can be the result of a flipped bit.
  static constexpr int impossible_max = 2;

  const std::uint32_t writer_;
  const std::uint32_t channel_;
  KeptSamples kept_;
  RepairQueue repairs_;
  HeartbeatSchedule heartbeats_;
  bool repair_was_last_ = false;
  int impossible_ = 0;
  bool heard_ = false;  ///< true if the receiver knows the channel
};

}  // namespace sft::udp
