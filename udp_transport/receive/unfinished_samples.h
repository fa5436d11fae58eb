// The samples of one writer that have begun and are not whole yet. A sample is found by its label in
// bounded time, however many have begun, because forged datagrams can begin any number of samples. Uses no
// clock, thread or I/O.
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
  /// Returns the samples without a place in a channel, the oldest first. Callers of add() limit their
  /// number.
  const std::vector<Handle>& loose() const { return loose_; }
  /// Returns the samples that have a place in a channel, in any order.
  const std::vector<Handle>& placed() const { return placed_; }

  /// Returns the sample; null if it has not begun. The pointer is valid until the sample is removed.
  UnfinishedSample* find(const SampleLabel& label) const { return empty() ? nullptr : search(label); }
  /// Adds a sample. REQUIRES: no sample here has the same label.
  UnfinishedSample& add(Handle sample);
  /// Removes a sample and returns it; returns null if it is not here.
  Handle remove(const SampleLabel& label);
  /// Gives a sample its place in the channel of the writer. 0: the sample has no place any more.
  void set_place(UnfinishedSample& sample, std::uint64_t place);
  /// Removes the places in a channel from all samples.
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
  std::vector<Handle> placed_;  ///< each sample knows its index in this vector
  mutable std::vector<UnfinishedSample*> buckets_{
      8};  ///< hash table of the samples with a place; the number of buckets is a power of two
  mutable UnfinishedSample* last_found_ = nullptr;
};

}  // namespace sft::udp
