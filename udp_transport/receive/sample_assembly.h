// The samples of one writer that are being assembled. Their number and memory are limited. Uses no clock,
// thread or I/O.
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

  /// Returns the sample; null if no datagram of it has come. The pointer is valid until the sample is
  /// removed.
  UnfinishedSample* find(const SampleLabel& label) const { return unfinished_.find(label); }
  /// Begins a sample. If it is in no channel (place 0), the oldest samples are dropped if there are too
  /// many.
  UnfinishedSample& begin(const SampleLabel& label, std::uint64_t place, Time now);
  /// Notes that the first datagram of the sample has come. `buffer` must be large enough for the whole body.
  void describe(UnfinishedSample& sample, const FirstHeader& first, std::size_t body_offset,
                core::SampleHandle buffer);
  void set_place(UnfinishedSample& sample, std::uint64_t place) { unfinished_.set_place(sample, place); }
  enum class Parked : std::uint8_t { yes, beyond_body, over_limit };
  /// Keeps (parks) a datagram that came before the first datagram of its sample. `sample_bytes` is the
  /// maximum length of a body.
  Parked park(UnfinishedSample& sample, const Following& d, std::size_t sample_bytes, Time now);
  /// Adds the parked datagrams to the sample. Its first datagram must have come.
  UnfinishedSample::Added unpark(UnfinishedSample& sample, Time now);

  /// Notes that further datagrams of this sample are ignored.
  void finish(const SampleLabel& label) { finished_.add(label); }
  bool is_finished(const SampleLabel& label) const { return finished_.contains(label); }

  /// Removes and returns a sample; returns null if no datagram of it has come.
  UnfinishedSamples::Handle remove(const SampleLabel& label);
  /// Removes a sample without finishing it, so that it begins anew when its datagrams come again.
  void give_back(const SampleLabel& label);
  /// Gives a sample up, even if no datagram of it has come, and increments `counter`. Returns the sample's
  /// place in the channel; 0 if it was in no channel.
  std::uint64_t drop(const SampleLabel& label, std::uint64_t& counter);
  /// Drops samples outside of channels that have made no progress for too long. (The channel decides about
  /// its samples.) Sets `next` to the time when the next sample may be dropped, if that is earlier.
  void expire(Time now, std::optional<Time>& next);
  /// Notes that the samples are in no channel any more, so that each of them can expire.
  void forget_places();

  /// Takes memory for a sample that is in no channel. If memory is short, older samples of the writer are
  /// dropped. Returns null if the memory still does not suffice.
  core::SampleHandle take_buffer(std::size_t buffer_bytes, const SampleLabel& label, std::size_t body_bytes,
                                 bool is_whole);
  /// Takes memory for a sample of a channel. No other sample is dropped for it, since the sample can come
  /// again later. `reserved_bytes` of the pool stay unused, in addition to the bytes that are reserved for
  /// publishers. Returns null if the memory does not suffice.
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
