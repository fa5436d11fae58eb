// Samples that came by unicast, and wait because an earlier one may still lie in the socket of groups.
// Where a group ends, its last sample and the next one come by two sockets, whose order is not kept.
// Reliable readers do not need this, since they get samples in the order of their channel. Uses no clock,
// thread or I/O: samples are passed in, and returned in the order of their sequences.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/seam/sample_buffer.h"

namespace sft::udp {

/// Used by one thread.
class HandOver {
 public:
  struct Waiting {
    core::SampleHandle sample;  ///< null: no sample waits
    bool in_channel = false;    ///< reliable readers get the sample in the order of the channel
    bool overtakes = false;     ///< an earlier sample is missing, as far as is known
  };

  /// Returns true if a sample waits. If none does, no other function has to be called.
  bool is_under_way() const { return !waiting_.empty(); }
  /// Returns true if a sample of the writer waits.
  bool concerns(core::EndpointId writer) const;
  void add(Waiting one);
  /// Takes out the next sample of the writer, unless an earlier one is missing.
  Waiting next(core::EndpointId writer);
  /// Takes out the next sample of any writer, whatever is missing, because nothing more lies in the socket
  /// of groups.
  Waiting next();
  /// Returns true if so many samples wait that they should not use more memory.
  bool is_full() const { return waiting_.size() >= waiting_max; }

 private:
  static constexpr std::size_t waiting_max = 512;

  std::vector<Waiting>::iterator first_of(core::EndpointId writer);
  Waiting take(std::vector<Waiting>::iterator which);

  std::vector<Waiting> waiting_;  ///< in the order of their sequences; keeps its capacity
  core::EndpointId last_of_ = 0;  ///< the writer of the sample that was taken out last
  std::uint64_t last_ = 0;        ///< the sequence of that sample
};

}  // namespace sft::udp
