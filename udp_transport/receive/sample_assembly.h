// The samples of one writer that are being assembled, within the limits on their number and memory. Uses no
// clock, thread or I/O.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "udp_transport/receive/reassembly_memory.h"
#include "udp_transport/receive/recent_labels.h"
#include "udp_transport/receive/unfinished_samples.h"

namespace sft::udp {

class SampleAssembly {
 public:
  using Time = ReassemblyMemory::Time;

  /// `shared` must outlive this object.
  explicit SampleAssembly(ReassemblyMemory& shared) : shared_(shared) {}
  /// Drops all samples without counting them.
  ~SampleAssembly();
  SampleAssembly(const SampleAssembly&) = delete;
  SampleAssembly& operator=(const SampleAssembly&) = delete;

  /// Returns the sample; null if it has not begun. The pointer is valid until the sample is removed.
  UnfinishedSample* find(const SampleLabel& label) const { return unfinished_.find(label); }
  /// Begins a sample. If it has no place in a channel, the oldest samples are dropped to make room for it.
  UnfinishedSample& begin(const SampleLabel& label, std::uint64_t place, Time now);
  /// Notes that the first datagram of the sample has come. The buffer has room for the whole body.
  void describe(UnfinishedSample& sample, const FirstHeader& first, std::size_t body_offset,
                core::SampleHandle buffer);
  void set_place(UnfinishedSample& sample, std::uint64_t place) { unfinished_.set_place(sample, place); }
  enum class Parked : std::uint8_t { yes, beyond_body, over_limit };
  /// Keeps a datagram that came before the first one of its sample. `sample_bytes` is the limit of a body's
  /// length.
  Parked park(UnfinishedSample& sample, const Following& d, std::size_t sample_bytes, Time now);
  /// Adds the kept datagrams that came before the first one.
  UnfinishedSample::Added unpark(UnfinishedSample& sample, Time now);

  /// Notes that further datagrams of this sample are ignored.
  void finish(const SampleLabel& label) { finished_.add(label); }
  bool is_finished(const SampleLabel& label) const { return finished_.contains(label); }

  /// Takes a sample out; returns null if it has not begun.
  UnfinishedSamples::Handle remove(const SampleLabel& label);
  /// Removes a sample that begins anew if its datagrams come again.
  void give_back(const SampleLabel& label);
  /// Gives a sample up, even if it has not begun, and increments `counter`. Returns its place in the
  /// channel; 0 if it had none.
  std::uint64_t drop(const SampleLabel& label, std::uint64_t& counter);
  /// Drops samples without a place in a channel that have made no progress for too long. The channel
  /// decides about samples with a place. Lowers `next` to the time when the next sample may be dropped.
  void expire(Time now, std::optional<Time>& next);
  /// Removes the places in a channel from all samples, so that each of them can expire.
  void forget_places();

  /// Takes memory for a sample without a place in a channel. If memory is short, older samples of the
  /// writer are dropped. Returns null if there is still not enough memory.
  core::SampleHandle take_buffer(std::size_t buffer_bytes, const SampleLabel& label, std::size_t body_bytes,
                                 bool is_whole);
  /// Takes memory for a sample with a place in a channel. No other sample is dropped for it, since it can
  /// come again later. `reserved_bytes` of the pool stay unused, in addition to the part that is reserved
  /// for publishers.
  core::SampleHandle take_reliable_buffer(std::size_t buffer_bytes, std::size_t body_bytes,
                                          std::size_t reserved_bytes);

 private:
  bool drop_oldest(const SampleLabel& same_variant_first);

  ReassemblyMemory& shared_;
  UnfinishedSamples unfinished_;
  std::size_t described_bytes_ = 0;  ///< number of bytes of all bodies whose first datagram has come
  RecentLabels finished_;
};

}  // namespace sft::udp
