// The writer's end of a channel (wire_format.md). It keeps samples that were sent to one process until that
// process has acknowledged them, and decides what to send next: samples, repairs, heartbeats. Uses no
// clock, thread or I/O: calls and times are passed in, decisions are returned.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "udp_transport/outgoing/job.h"
#include "udp_transport/outgoing/kept_memory.h"
#include "udp_transport/reliable/heartbeat_schedule.h"
#include "udp_transport/reliable/kept_samples.h"
#include "udp_transport/reliable/repair_queue.h"
#include "udp_transport/reliable/resend_limits.h"
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
    std::uint32_t part = 0;  ///< index in its pack of the first sample to send
    std::uint32_t samples = 1;
    EncodedBody body() const { return job->body(first, part, samples); }
  };

  /// `memory` counts the memory that all channels keep.
  ResendWindow(std::uint32_t writer, std::uint32_t channel, const ResendLimits& limits,
               std::uint64_t first_ordinal = 1, std::shared_ptr<const KeptMemory> memory = {});

  /// Gives a sample, or each sample of a pack, its place in the channel. `ordinal` of the result is that of
  /// the first kept sample. The job must not change any more; `first` is its header. If `elsewhere` (never
  /// for packs), a group sends the sample, and this channel only repairs it. If more than half of the limit
  /// is kept, this channel sends the sample, too.
  Kept keep(JobHandle job, FirstHeader first, bool elsewhere = false);
  /// Notes that the group has sent the sample with this ordinal.
  void departed(std::uint64_t ordinal, Time now);

  /// Returns the piece that may be sent now. It counts as being sent until finished() or put_back() is
  /// called.
  std::optional<Piece> next(Size size, Time now);
  /// Takes the sample with this ordinal, if it is the next one to be sent.
  std::optional<Piece> take(std::uint64_t ordinal);
  void finished(const Piece& piece, Time now);
  /// Puts the piece back: its rest, from the beginning of its range, is sent later.
  void put_back(const Piece& piece);
  /// Returns true if no sample waits to be sent or is under way for the first time.
  bool all_sent() const { return kept_.sent_end() == kept_.end(); }
  bool keeps(std::uint64_t ordinal) const { return kept_.contains(ordinal); }

  /// Returns the job of a sample that was sent elsewhere; null for other samples. The header of the job is
  /// the one that was used there.
  JobHandle sent_elsewhere(std::uint64_t ordinal) const;

  /// Takes an ack. An implausible ack is ignored. An ack of another channel of the writer shows that the
  /// receiver may follow a wrong channel. Then samples name this channel with its full number, and a
  /// heartbeat is due at once. A part that was sent again within `round_trip` is still under way, and is
  /// not sent once more.
  void hear(const Ack& ack, Time now, Time::duration round_trip = {});
  /// Returns true if the receiver has acknowledged samples that were never sent. Only a fault can cause
  /// that, so its acks of this channel are ignored.
  bool gone_wrong() const { return impossible_ >= impossible_max; }

  /// Notes that the path has changed. A heartbeat is due at once, because it also gives the receiver the
  /// new address for acks.
  void way_changed(Time now) { heartbeats_.way_changed(kept_.amount(), now); }

  /// Returns a heartbeat if one is due. The caller sets its port.
  std::optional<Heartbeat> heartbeat(Time now);
  /// Returns the last heartbeat. It says that no sample is kept any more.
  Heartbeat parting() const;

  /// Returns when the next check is due if nothing happens until then; Time::max() if there is none.
  Time next_look(Time now) const;
  /// Returns true if `samples` samples with `bytes` bytes can be kept without giving up older ones.
  bool can_keep(std::size_t samples, std::size_t bytes) const { return kept_.can_keep(samples, bytes); }
  /// Returns true if nothing is left to be sent or acknowledged.
  bool settled() const { return kept_.size() == 0; }

  /// Returns the bytes of the sample's body, if the sample was sent and is kept.
  std::optional<std::uint32_t> bytes_sent(std::uint64_t ordinal) const;
  /// The samples in [begin(), end()) are kept.
  std::uint64_t begin() const { return kept_.begin(); }
  std::uint64_t end() const { return kept_.end(); }

  /// Returns true if something is to be sent.
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

  /// The number of acks in a row of samples that were never sent after which the channel has gone wrong. A
  /// single one can be a flipped bit.
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
