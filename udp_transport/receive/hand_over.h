// Samples that wait because they came alone while one before them may still lie in the socket of groups:
// where a group ends, its last sample and the next one come by two sockets, and nobody keeps the order of
// these. Reliable readers need none of this, since they get samples in the order of their channel. Pure:
// samples go in, and come out in the order of their sequences.
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
    core::SampleHandle sample;  ///< empty: there is none
    bool in_channel = false;    ///< reliable readers get it in its turn
    bool overtakes = false;     ///< one before it is missing, as far as is known
  };

  /// Something waits. As long as nothing does, nothing else has to be asked.
  bool is_under_way() const { return !waiting_.empty(); }
  /// Some sample of the writer waits.
  bool concerns(core::EndpointId writer) const;
  void add(Waiting one);
  /// Takes out the next one of the writer, unless something before it is missing.
  Waiting next(core::EndpointId writer);
  /// Takes out the next one of any writer, whatever is missing: nothing more lies in the socket of groups.
  Waiting next();
  /// So many wait that no more memory should go for them.
  bool is_full() const { return waiting_.size() >= waiting_max; }

 private:
  static constexpr std::size_t waiting_max = 512;

  std::vector<Waiting>::iterator first_of(core::EndpointId writer);
  Waiting take(std::vector<Waiting>::iterator which);

  std::vector<Waiting> waiting_;  ///< by ascending sequence; as large as was needed so far
  core::EndpointId last_of_ = 0;  ///< the writer of what was taken out last
  std::uint64_t last_ = 0;        ///< and its sequence
};

}  // namespace sft::udp
