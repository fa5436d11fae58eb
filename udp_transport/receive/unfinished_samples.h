// The samples of one writer that are not whole yet. A sample is found by its label in bounded time, however
// many samples there are. This is necessary because forged datagrams can begin any number of samples. Uses
// no clock, thread or I/O.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "udp_transport/receive/unfinished_sample.h"

namespace sft::udp {

class UnfinishedSamples {
 public:
  using Handle = std::unique_ptr<UnfinishedSample>;

  bool empty() const { return loose_.empty() && placed_.empty(); }
  /// Returns the samples that are in no channel, the oldest first. Callers of add() must limit their number.
  const std::vector<Handle>& loose() const { return loose_; }
  /// Returns the samples that are in a channel, in any order.
  const std::vector<Handle>& placed() const { return placed_; }

  /// Returns the sample; null if no sample has that label. The pointer is valid until the sample is removed.
  UnfinishedSample* find(const SampleLabel& label) const { return empty() ? nullptr : search(label); }
  /// Adds a sample. REQUIRES: no unfinished sample of this writer has the same label.
  UnfinishedSample& add(Handle sample);
  /// Removes and returns the sample; returns null if no sample has that label.
  Handle remove(const SampleLabel& label);
  /// Sets the sample's place in the channel of the writer; 0: the sample is in no channel any more.
  void set_place(UnfinishedSample& sample, std::uint64_t place);
  /// Notes that no sample is in a channel any more.
  void forget_places();

 private:
  UnfinishedSample* search(const SampleLabel& label) const;
  static std::size_t hash_of(const SampleLabel& label) {
    const std::uint64_t key = std::uint64_t{label.sequence} << 16 | label.variant;
    return static_cast<std::size_t>((key * 0x9e37'79b9'7f4a'7c15) >> 32);
  }
  UnfinishedSample*& bucket_of(const SampleLabel& label) const {
    return buckets_[hash_of(label) & (buckets_.size() - 1)];
  }
  void insert(UnfinishedSample& sample);
  void place(Handle sample);
  Handle take_loose(const SampleLabel& label);
  Handle take_placed(UnfinishedSample& sample);

  std::vector<Handle> loose_;
  std::vector<Handle> placed_;  ///< each sample has its index in this vector
  mutable std::vector<UnfinishedSample*> buckets_{
      8};  ///< hash table of `placed_`; the number of buckets is a power of two
  mutable UnfinishedSample* last_found_ = nullptr;
};

}  // namespace sft::udp
