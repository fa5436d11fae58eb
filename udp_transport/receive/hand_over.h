// Samples that came by unicast, and wait because an earlier sample may still be in the socket for groups.
// When a writer stops using a multicast group, the group's last sample and the next sample come by two
// sockets, so their order is not known. Reliable readers do not need this class, since they get samples in
// the order of their channel. Uses no clock, thread or I/O: samples are passed in, and returned in the order
// of their sequences.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/seam/sample_buffer.h"

namespace sft::udp {

/// All functions must be called by the same thread.
class HandOver {
 public:
  struct Waiting {
    core::SampleHandle sample;  ///< the sample that waits; null: no sample waits
    bool in_channel = false;    ///< true if reliable readers get the sample in the order of the channel
    bool overtakes = false;     ///< true if an earlier sample is missing, as far as this process knows
  };

  /// Returns true if a sample waits. If no sample waits, no other function has to be called.
  bool is_under_way() const { return !waiting_.empty(); }
  /// Returns true if a sample of the writer waits.
  bool concerns(core::EndpointId writer) const;
  void add(Waiting one);
  /// Removes and returns the next waiting sample of the writer. Returns no sample if an earlier sample is
  /// missing.
  Waiting next(core::EndpointId writer);
  /// Removes and returns the next waiting sample of any writer, even if an earlier sample is missing. Call
  /// this only if the socket for groups is empty, or if is_full() returns true.
  Waiting next();
  /// Returns true if the maximum number of samples waits. The maximum limits the memory of waiting samples.
  bool is_full() const { return waiting_.size() >= waiting_max; }

 private:
  static constexpr std::size_t waiting_max = 512;

  std::vector<Waiting>::iterator first_of(core::EndpointId writer);
  Waiting take(std::vector<Waiting>::iterator which);

  /// The samples in the order of their sequences; the vector keeps its capacity.
  std::vector<Waiting> waiting_;
  core::EndpointId last_of_ = 0;  ///< the writer of the sample that was removed last
  std::uint64_t last_ = 0;        ///< the sequence of that sample
};

}  // namespace sft::udp
