// The writer's end of a channel (wire_format.md): samples that were sent to one process and are kept until it
// has acknowledged them, and what is to be sent next: samples, repairs, heartbeats. Pure: calls and times in,
// decisions out; no I/O, no clock, no thread of its own.
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

  /// A sample to be sent, or a part of it once more.
  struct Piece {
    FirstHeader first;
    JobHandle job;
    BodyRange range{};
    std::uint64_t ordinal = 0;
    bool is_repair = false;
    std::uint32_t part = 0;  ///< of a pack, its first sample that is to be sent, and how many are
    std::uint32_t samples = 1;
    EncodedBody body() const { return job->body(first, part, samples); }
  };

  /// `memory` is what all channels keep.
  ResendWindow(std::uint32_t writer, std::uint32_t channel, const ResendLimits& limits,
               std::uint64_t first_ordinal = 1, std::shared_ptr<const KeptMemory> memory = {});

  /// Gives a sample, or each one of a pack, its place in the channel; the ordinal is the first of those that
  /// are kept. The job does not change any more. `first` is its header. `elsewhere`, which packs never are: a
  /// group sends the sample, and this channel only repairs it. If more than half of what may be kept is kept,
  /// this channel sends the sample, too.
  Kept keep(JobHandle job, FirstHeader first, bool elsewhere = false);
  /// The group has sent the sample with this ordinal.
  void departed(std::uint64_t ordinal, Time now);

  /// Returns the piece that may be sent now; it counts as being sent until finished() or put_back() is
  /// called.
  std::optional<Piece> next(Size size, Time now);
  /// Takes that very sample, if it is the next one to be sent.
  std::optional<Piece> take(std::uint64_t ordinal);
  void finished(const Piece& piece, Time now);
  /// The rest of the piece, from where its range begins, is sent later.
  void put_back(const Piece& piece);
  /// Nothing waits or is under way for the first time.
  bool all_sent() const { return kept_.sent_end() == kept_.end(); }
  bool keeps(std::uint64_t ordinal) const { return kept_.contains(ordinal); }

  /// Returns the job of a sample that was sent elsewhere; its own header is the one used there. Empty for
  /// others.
  JobHandle sent_elsewhere(std::uint64_t ordinal) const;

  /// Takes an ack of the other end; nonsense is ignored. An ack of another channel of the writer shows that
  /// the other end may follow a wrong one: samples then name this one in full, and a heartbeat does at once.
  /// A part that was sent again within `round_trip` is still on its way there, and is not sent once more.
  void hear(const Ack& ack, Time now, Time::duration round_trip = {});
  /// The other end says that it has got what was never sent, as it could not but for a fault: what it says
  /// of this channel means nothing any more.
  bool gone_wrong() const { return impossible_ >= impossible_max; }

  /// The way there is another one: asks at once, which also tells the other end where acks go now.
  void way_changed(Time now) { heartbeats_.way_changed(kept_.amount(), now); }

  /// Empty if none is due. Its port is left to the caller.
  std::optional<Heartbeat> heartbeat(Time now);
  /// The last one: nothing is kept any more.
  Heartbeat parting() const;

  /// The time to look again, if nothing happens until then; Time::max() if never.
  Time next_look(Time now) const;
  /// Returns true if so much more can be kept, and nothing has to go for it.
  bool can_keep(std::size_t samples, std::size_t bytes) const { return kept_.can_keep(samples, bytes); }
  /// Nothing is left to be sent or acknowledged.
  bool settled() const { return kept_.size() == 0; }

  /// Bytes of the body, if that sample was sent and is kept.
  std::optional<std::uint32_t> bytes_sent(std::uint64_t ordinal) const;
  /// [begin, end) are kept.
  std::uint64_t begin() const { return kept_.begin(); }
  std::uint64_t end() const { return kept_.end(); }

  /// Something is to be sent.
  bool has_work();

  std::size_t kept() const { return kept_.size(); }
  std::size_t kept_bytes() const { return kept_.bytes(); }
  std::uint64_t repairs() const { return repairs_.sent(); }  ///< parts that were sent again

 private:
  Piece piece_of(std::uint64_t ordinal) const;
  std::optional<Piece> next_repair(Size size, Time now);
  std::optional<Piece> next_sample(Size size);
  Piece begin_sample(std::uint64_t ordinal);
  void ask_for(const Missing& part, std::uint64_t next, Time now);

  /// Acks of what was never sent, one after the other: one can be a flipped bit.
  static constexpr int impossible_max = 2;

  const std::uint32_t writer_;
  const std::uint32_t channel_;
  KeptSamples kept_;
  RepairQueue repairs_;
  HeartbeatSchedule heartbeats_;
  bool repair_was_last_ = false;
  int impossible_ = 0;
  bool heard_ = false;  ///< the other end knows the channel
};

}  // namespace sft::udp
