// The samples that a channel keeps until they are acknowledged, in the order of their ordinals: which of them
// wait to be sent, are under way for the first time, or were sent. Pure.
//
// There are never more samples or bytes than allowed, but for the newest sample: the oldest ones go.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "udp_transport/outgoing/job.h"
#include "udp_transport/outgoing/kept_memory.h"
#include "udp_transport/reliable/ordinal_ring.h"
#include "udp_transport/reliable/resend_limits.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class KeptSamples {
 public:
  /// One of two queues, so that a large sample does not hold up small ones. Small is what one system call
  /// sends. (Job::is_small() is narrower: it is what the publisher's thread sends itself.)
  enum class Size : std::uint8_t { small, large };
  static Size size_of(std::size_t bytes) { return bytes <= batch_bytes_max ? Size::small : Size::large; }

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
    Size size() const { return size_of(first.total); }
  };

  /// `memory` is what all channels keep; null: there is no limit in all.
  KeptSamples(const ResendLimits& limits, std::uint64_t first_ordinal,
              std::shared_ptr<const KeptMemory> memory);

  struct Kept {
    std::uint64_t ordinal = 0;
    // Older samples that had to go and were never sent:
    std::size_t dropped = 0;
    std::uint64_t dropped_bytes = 0;
    std::uint64_t dropped_whole_bytes = 0;
    std::size_t unacknowledged = 0;  ///< that had to go, too, and were sent: they may still arrive
    bool elsewhere = false;          ///< as was asked for
  };
  /// Keeps a sample, or each one of a pack; the ordinal is the first of those that are kept. `elsewhere`: the
  /// sample is being sent by somebody else, unless more than half of what may be kept is.
  Kept keep(const JobHandle& job, const FirstHeader& first, bool elsewhere);
  /// Returns true if so much more can be kept, and nothing has to go for it.
  bool can_keep(std::size_t samples, std::size_t bytes) const;
  /// The amount that is kept, of what may be.
  enum class Amount : std::uint8_t { nothing, at_most_half, more_than_half };
  Amount amount() const;

  /// The first sample of that size that waits; end() if none does.
  std::uint64_t first_waiting(Size size);
  /// Begins to send the sample, and so many behind it as wait, too, and are of the same pack. Returns how
  /// many these are in all.
  std::uint32_t begin_sending(std::uint64_t ordinal);
  /// Tells that so many samples have been sent; those that are not kept any more do not count.
  void sent(std::uint64_t ordinal, std::uint32_t samples);
  /// A group has sent the sample. Returns true for the first time; empty for samples that no group sends.
  std::optional<bool> departed(std::uint64_t ordinal);
  /// Puts so many samples back: each is to be sent on from that byte.
  void put_back(std::uint64_t ordinal, std::uint32_t samples, std::uint32_t sent_bytes);
  /// Each sample before was sent, or is gone.
  std::uint64_t sent_end() const;

  /// Lets go of samples that the other end has, or has given up. It can have only what has begun.
  void release_before(std::uint64_t next);

  bool contains(std::uint64_t ordinal) const { return entries_.contains(ordinal); }
  const Entry& operator[](std::uint64_t ordinal) const { return entries_[ordinal]; }
  std::uint64_t begin() const { return entries_.begin(); }
  std::uint64_t end() const { return entries_.end(); }
  std::size_t size() const { return entries_.size(); }
  std::size_t bytes() const { return bytes_; }

 private:
  bool keeps_more_than(std::size_t samples, std::size_t bytes) const;
  std::size_t bytes_max(std::size_t added) const;
  void make_room(Kept& kept, std::size_t added);
  void release_oldest();
  static void start(Entry& entry);

  const std::size_t samples_max_;
  const std::size_t bytes_max_;
  const std::shared_ptr<const KeptMemory> memory_;
  OrdinalRing<Entry> entries_;
  std::uint64_t waiting_[2];  ///< by Size: no entry of that size before this one waits
  std::uint64_t sent_;        ///< each before this one was sent
  std::size_t bytes_ = 0;
};

}  // namespace sft::udp
