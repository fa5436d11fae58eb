// The samples that a channel keeps until they are acknowledged, in the order of their ordinals. Each of
// them waits to be sent, is under way for the first time, or was sent. Uses no clock, thread or I/O.
//
// The number of samples and their bytes are limited, but the newest `samples_least` samples are kept however
// large they are. If a limit is exceeded, the oldest samples are given up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "udp_transport/outgoing/job.h"
#include "udp_transport/outgoing/kept_memory.h"
#include "udp_transport/outgoing/resend_limits.h"
#include "udp_transport/reliable/ordinal_ring.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class KeptSamples {
 public:
  /// The size class of a sample. Each class has its own queue, so that a large sample does not delay small
  /// ones. A small sample can be sent by one system call. (The limit of Job::is_small() is lower: the
  /// publisher's thread sends such a sample itself.)
  enum class Size : std::uint8_t { small, large };
  static Size size_of(std::size_t bytes) { return bytes <= batch_bytes_max ? Size::small : Size::large; }

  enum class State : std::uint8_t { waiting, under_way, sent };
  struct Entry {
    FirstHeader first;
    JobHandle job;
    std::uint32_t part = 0;        ///< index of the sample in its pack; 0 if the job is no pack
    std::uint32_t sent_bytes = 0;  ///< number of bytes of the sample's body that were sent before put_back()
    State state = State::waiting;
    bool begun = false;  ///< true if at least a part of the sample was sent
    bool elsewhere = false;
    std::size_t held_bytes() const { return job->held_bytes(part); }
    Size size() const { return size_of(first.total); }
  };

  /// `memory` counts the memory that all channels keep; null: there is no common limit.
  KeptSamples(const ResendLimits& limits, std::uint64_t first_ordinal,
              std::shared_ptr<const KeptMemory> memory);

  struct Kept {
    std::uint64_t ordinal = 0;
    // Older samples that were given up before they were sent: their number, and their bytes.
    std::size_t dropped = 0;
    std::uint64_t dropped_bytes = 0;
    std::uint64_t dropped_whole_bytes = 0;
    /// The number of samples that were given up after they were sent. They may still arrive.
    std::size_t unacknowledged = 0;
    bool elsewhere = false;  ///< true if a multicast group sends the sample, as requested
  };
  /// Keeps a sample, or each sample of a pack. `ordinal` of the result is that of the first kept sample. If
  /// `elsewhere` is true, a multicast group sends the sample. That is refused, and reported in the result,
  /// if more than half of a limit is in use.
  Kept keep(const JobHandle& job, const FirstHeader& first, bool elsewhere);
  /// Returns true if `samples` samples with `bytes` bytes can be kept without giving up older ones.
  bool can_keep(std::size_t samples, std::size_t bytes) const;
  /// The amount of samples that are kept, relative to the limits. At most half of `samples_least` samples are
  /// not more than half, however large they are.
  enum class Amount : std::uint8_t { nothing, at_most_half, more_than_half };
  Amount amount() const;

  /// Returns the ordinal of the first waiting sample of that size; end() if there is none.
  std::uint64_t first_waiting(Size size);
  /// Notes that the sample and the waiting samples that follow it in the same pack are being sent. Returns
  /// the number of these samples.
  std::uint32_t begin_sending(std::uint64_t ordinal);
  /// Notes that `samples` samples have been sent. Samples that are not kept any more are ignored.
  void sent(std::uint64_t ordinal, std::uint32_t samples);
  /// Notes that a multicast group has sent the sample. Returns true for the first call, and false for later
  /// ones. Returns nothing for a sample that no group sends.
  std::optional<bool> departed(std::uint64_t ordinal);
  /// Makes `samples` samples wait again. Each has to be sent from byte `sent_bytes` of its body on.
  void put_back(std::uint64_t ordinal, std::uint32_t samples, std::uint32_t sent_bytes);
  /// Returns the first ordinal whose sample has not been sent yet; end() if all have been sent.
  std::uint64_t sent_end() const;

  /// Releases the samples with ordinals less than `next`. The receiver has received them or given them up.
  /// Samples of which no part has been sent stay.
  void release_before(std::uint64_t next);

  bool contains(std::uint64_t ordinal) const { return entries_.contains(ordinal); }
  const Entry& operator[](std::uint64_t ordinal) const { return entries_[ordinal]; }
  std::uint64_t begin() const { return entries_.begin(); }
  std::uint64_t end() const { return entries_.end(); }
  std::size_t size() const { return entries_.size(); }
  std::size_t bytes() const { return bytes_; }

 private:
  bool keeps_more_than(std::size_t samples, std::size_t bytes) const;
  std::size_t bytes_max_of_memory(std::size_t added) const;
  bool must_give_up(std::size_t bytes_max_of_memory, bool half) const;
  void make_room(Kept& kept, std::size_t added);
  void release_oldest();
  static void start(Entry& entry);

  const std::size_t samples_max_;
  const std::size_t bytes_max_;
  const std::size_t samples_least_;
  const std::shared_ptr<const KeptMemory> memory_;
  OrdinalRing<Entry> entries_;
  std::uint64_t waiting_[2];  ///< by Size: no entry of that size with a lower ordinal waits
  std::uint64_t sent_;        ///< each entry with a lower ordinal was sent
  std::size_t bytes_ = 0;
};

}  // namespace sft::udp
