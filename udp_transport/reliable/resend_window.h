// The writer's end of a channel (wire_format.md): samples that were sent to one process and are kept until it
// has acknowledged them, and what is to be sent next: samples, repairs, heartbeats. Pure: calls and times in,
// decisions out; no I/O, no clock, no thread of its own.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "udp_transport/flow/pacer.h"
#include "udp_transport/outgoing/job.h"
#include "udp_transport/outgoing/kept_memory.h"
#include "udp_transport/reliable/ordinal_ring.h"
#include "udp_transport/wire/datagram.h"
#include "udp_transport/wire/fragmenter.h"

namespace sft::udp {

struct ResendLimits {
  std::size_t samples = 4096;                         ///< kept; beyond that the oldest goes
  std::size_t bytes = std::size_t{64} << 20;          ///< of memory that these hold, but for the newest
  std::uint64_t repair_bytes_per_s = 100'000'000;     ///< live samples have the rest
  std::chrono::milliseconds heartbeat_delay{20};      ///< after the last sample
  std::chrono::milliseconds heartbeat_pause{2000};    ///< on a good link, on average, where they are answered
  std::chrono::milliseconds heartbeat_period{4000};   ///< while samples come as usual
  int heartbeats_saved = 4;                           ///< that may follow each other faster
  std::chrono::seconds mistrust{10};                  ///< of a link, after it has lost something
  std::chrono::milliseconds heartbeat_longest{1000};  ///< between two that were not
};

class ResendWindow {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// One of two queues, so that a large sample does not hold up small ones.
  enum class Size : std::uint8_t { small, large };
  static Size size_of(std::size_t bytes) { return bytes <= batch_bytes_max ? Size::small : Size::large; }

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

  struct Kept {
    std::uint64_t ordinal = 0;
    // Older samples that had to go and were never sent:
    std::size_t dropped = 0;
    std::uint64_t dropped_bytes = 0;
    std::uint64_t dropped_whole_bytes = 0;
    std::size_t unacknowledged = 0;  ///< that had to go, too, and were sent: they may still arrive
    bool elsewhere = false;          ///< as was asked for
  };
  /// Gives a sample, or each one of a pack, its place in the channel; the ordinal is the first of those that
  /// are kept. The job does not change any more. `first` is its header. `elsewhere`, not of packs: it is
  /// being sent by a group and only repaired by this, as long as at most half of what may be kept is; else it
  /// is sent by this.
  Kept keep(JobHandle job, FirstHeader first, bool elsewhere = false);
  /// One that was sent elsewhere has left.
  void departed(std::uint64_t ordinal, Time now);

  /// Returns the piece that may be sent now; it counts as being sent until finished() or put_back() is
  /// called.
  std::optional<Piece> next(Size size, Time now);
  /// Takes that very sample, if it is its turn.
  std::optional<Piece> take(std::uint64_t ordinal);
  void finished(const Piece& piece, Time now);
  /// The rest of the piece, from where its range begins, is sent later.
  void put_back(const Piece& piece);
  /// Nothing waits or is under way for the first time.
  bool all_sent() const { return sent_end() == kept_.end(); }
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
  void way_changed(Time now);

  /// Empty if none is due. Its port is left to the caller.
  std::optional<Heartbeat> heartbeat(Time now);
  /// The last one: nothing is kept any more.
  Heartbeat parting() const;

  /// When to look again, if nothing is kept, heard and taken until then.
  Time next_look(Time now) const;
  /// Returns true if so much more can be kept, and nothing has to go for it.
  bool can_keep(std::size_t samples, std::size_t bytes) const;
  /// Nothing is left to be sent or acknowledged.
  bool settled() const { return kept_.empty(); }

  /// Bytes of the body, if that sample was sent and is kept.
  std::optional<std::uint32_t> bytes_sent(std::uint64_t ordinal) const;
  /// [begin, end) are kept.
  std::uint64_t begin() const { return kept_.begin(); }
  std::uint64_t end() const { return kept_.end(); }

  /// Something is to be sent.
  bool has_work();

  std::size_t kept() const { return kept_.size(); }
  std::size_t kept_bytes() const { return kept_bytes_; }
  std::uint64_t repairs() const { return repaired_; }  ///< parts that were sent again

 private:
  enum class State : std::uint8_t { waiting, under_way, sent };
  struct Entry {
    FirstHeader first;
    JobHandle job;
    std::uint32_t part = 0;        ///< its number in the pack that the job is
    std::uint32_t sent_bytes = 0;  ///< of its body, before it was put back
    State state = State::waiting;
    bool begun = false;  ///< once, if only a part of it was sent
    bool elsewhere = false;
    std::size_t held_bytes() const { return job->held_bytes(part); }
  };
  struct Repair {
    std::uint64_t ordinal = 0;
    BodyRange range;
    Size size{};
  };

  void push(const JobHandle& job, const FirstHeader& first);
  void name_channel_in_full(Time now);
  void start(Entry& entry);
  std::optional<Piece> next_repair(Size size, Time now);
  std::optional<Piece> next_sample(Size size);
  std::uint64_t first_waiting(Size size);
  Piece begin(std::uint64_t ordinal);
  bool keeps_more_than(std::size_t samples, std::size_t bytes) const;
  std::size_t bytes_max(std::size_t added) const;
  void make_room(Kept& kept, std::size_t added);
  void release_oldest();
  std::uint64_t sent_end() const;
  void release_before(std::uint64_t next);
  void ask_for(const Missing& part, std::uint64_t next, Time now);
  bool is_repaired_just_now(std::uint64_t ordinal, const BodyRange& range) const;
  static bool overlap(const BodyRange& a, const BodyRange& b) {
    return a == b || (a.begin < b.end && b.begin < a.end);
  }
  void plan_heartbeat(Time now);
  void learn_pause(Time::duration pause);
  Time end_of_usual_pause() const;

  const std::uint32_t writer_;
  const std::uint32_t channel_;
  const ResendLimits limits_;
  const std::shared_ptr<const KeptMemory> memory_;
  OrdinalRing<Entry> kept_;
  std::uint64_t waiting_[2];  ///< by Size: no entry of that size before this one waits
  std::uint64_t sent_;        ///< each before this one was sent
  std::size_t kept_bytes_ = 0;
  std::vector<Repair> repairs_;  ///< the oldest first
  bool repair_was_last_ = false;
  Pacer repair_pacer_;
  bool repair_is_paced_ = false;  ///< the last next() had to leave one for later
  std::uint64_t repaired_ = 0;
  struct Repaired {
    std::uint64_t ordinal = 0;
    BodyRange range;
    Time at{};
  };
  std::deque<Repaired> repaired_lately_;  ///< the oldest first: within a round trip, when an ack came last

  /// Acks of what was never sent, one after the other: one can be a flipped bit.
  static constexpr int impossible_max = 2;
  int impossible_ = 0;
  bool heard_ = false;  ///< the other end knows the channel

  Time sent_at_{};
  Time::duration usual_pause_{};  ///< between samples
  Time heartbeat_sent_at_{};
  Time heartbeats_paid_until_{};  ///< each costs a heartbeat_pause
  std::optional<Time> lost_at_;   ///< when something was asked for last
  int unanswered_ = 0;            ///< heartbeats
  bool answer_wanted_ = false;    ///< somebody asks for what is gone
  Time heartbeat_at_ = Time::max();
};

}  // namespace sft::udp
