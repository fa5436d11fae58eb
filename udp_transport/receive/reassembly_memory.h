// The limits, memory and counters for the assembly of samples. All writers that are read in a process share
// them.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/seam/buffer_pool.h"
#include "core/seam/transport.h"
#include "udp_transport/receive/unfinished_samples.h"
#include "udp_transport/reliable/arrival_window.h"

namespace sft::udp {

struct ReassemblyLimits {
  /// Maximum size of a body, whatever its writer announced.
  std::size_t sample_bytes = std::size_t{64} << 20;
  /// Maximum size of all unfinished bodies of a writer.
  std::size_t unfinished_bytes = std::size_t{128} << 20;
  std::size_t unfinished_per_variant = 4;  ///< maximum number of unfinished samples of a variant
  std::size_t unfinished_per_writer = 32;  ///< maximum number of unfinished samples of a writer
  /// The maximum memory of datagrams that came before the first datagram of their sample.
  std::size_t parked_bytes = std::size_t{512} << 10;
  std::size_t gaps = 4096;                 ///< maximum number of gaps in a sample
  std::chrono::milliseconds timeout{500};  ///< a sample without progress for this time is dropped
  ArrivalLimits channel{};                 ///< limits of the window of a reliable writer
};

/// The class is not thread-safe.
class ReassemblyMemory {
 public:
  using Time = std::chrono::steady_clock::time_point;

  ReassemblyMemory(const ReassemblyLimits& reassembly_limits, std::shared_ptr<core::BufferPool> sample_pool)
      : limits(reassembly_limits), pool(std::move(sample_pool)) {}

  /// Returns an unfinished sample without data. It reuses the memory of an earlier unfinished sample if
  /// possible.
  UnfinishedSamples::Handle begin_sample(const SampleLabel& label, std::uint64_t place, Time now);
  /// Notes that this sample was removed from the unfinished samples of its writer.
  void note_removed(const UnfinishedSample& sample);
  void recycle(UnfinishedSamples::Handle sample);

  bool can_park(std::size_t bytes) const { return parked_bytes_ + bytes <= limits.parked_bytes; }
  void note_parked(std::size_t bytes) { parked_bytes_ += bytes; }
  void note_unparked(std::size_t bytes) { parked_bytes_ -= bytes; }

  /// Returns the number of bytes of the pool that are reserved for the samples that this node publishes. So
  /// received samples, and samples that subscribers keep, cannot prevent this node from publishing.
  std::size_t reserved_for_publishers() const { return pool->limit_bytes() / 4; }

  /// Notes that memory for a sample could not be allocated within the limits.
  void note_refused(Time now) { refused_at_ = now; }
  /// Returns true if memory for a sample was refused recently. Then unfinished samples without progress have
  /// to release their memory.
  bool is_short(Time now) const { return now - refused_at_ < limits.channel.confirm_timeout; }

  /// Returns the time at which the next unfinished sample may have to be dropped; empty if there is no such
  /// sample.
  const std::optional<Time>& next_expiry() const { return next_expiry_; }
  void set_next_expiry(const std::optional<Time>& time) { next_expiry_ = time; }

  const ReassemblyLimits limits;
  const std::shared_ptr<core::BufferPool> pool;
  core::Transport::Counters counters;
  std::uint64_t datagrams = 0;             ///< number of received datagrams of samples
  bool group_reports_due = false;          ///< true if some writer waits for a report about its groups
  std::vector<core::SampleHandle> packed;  ///< the samples of the last packed datagram
  std::vector<core::SampleHandle>
      pack_buffers;  ///< memory for the remaining samples of the present packed datagram

 private:
  std::vector<UnfinishedSamples::Handle> recycled_;
  std::size_t unfinished_ = 0;  ///< number of unfinished samples of all writers
  std::size_t parked_bytes_ = 0;
  Time refused_at_{};
  std::optional<Time> next_expiry_;
};

inline UnfinishedSamples::Handle ReassemblyMemory::begin_sample(const SampleLabel& label, std::uint64_t place,
                                                                Time now) {
  if (recycled_.empty()) recycled_.push_back(std::make_unique<UnfinishedSample>());
  UnfinishedSamples::Handle sample = std::move(recycled_.back());
  recycled_.pop_back();
  sample->begin(label, now);
  sample->set_place(place);
  ++unfinished_;
  if (!next_expiry_) next_expiry_ = now + limits.timeout;
  return sample;
}

inline void ReassemblyMemory::note_removed(const UnfinishedSample& sample) {
  parked_bytes_ -= sample.parked_bytes();
  if (--unfinished_ == 0) next_expiry_.reset();
}

inline void ReassemblyMemory::recycle(UnfinishedSamples::Handle sample) {
  sample->clear();
  if (recycled_.size() < limits.unfinished_per_writer) recycled_.push_back(std::move(sample));
}

}  // namespace sft::udp
