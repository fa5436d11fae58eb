// The samples of one writer that have begun and are not whole yet. A sample is found by its label in
// bounded time, however many have begun, because anybody who sends datagrams decides how many these are.
// Uses no clock, thread or I/O.
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
  /// Samples without a place in a channel; the oldest is first. Callers of add() limit their number.
  const std::vector<Handle>& loose() const { return loose_; }
  /// Samples that have a place in a channel, in any order.
  const std::vector<Handle>& placed() const { return placed_; }

  /// Returns null if that sample has not begun. Valid until the sample is removed.
  UnfinishedSample* find(const SampleLabel& label) const { return empty() ? nullptr : search(label); }
  /// Adds a sample. REQUIRES: no other one has its label.
  UnfinishedSample& add(Handle sample);
  /// Removes a sample and returns it; null if it is not there.
  Handle remove(const SampleLabel& label);
  /// Gives a sample its place in the channel of the writer; 0: it has none any more.
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
  std::vector<Handle> placed_;  ///< each sample knows its index here
  mutable std::vector<UnfinishedSample*> buckets_{
      8};  ///< samples with a place; the number of buckets is a power of two
  mutable UnfinishedSample* last_found_ = nullptr;
};

}  // namespace sft::udp
