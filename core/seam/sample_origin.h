// The origin of a sample, by which readers order, count and choose samples: the numbers and stamps of the
// writer, and further values that the writer has sent with the sample.
#pragma once

#include <cstdint>

#include "core/seam/address.h"
#include "sft/detail/sample_format.h"

namespace sft::core {

struct SampleOrigin {
  // The following values are copied from the header at a time when the header is trustworthy. A header in
  // shared memory is never read again, since other processes may have changed it.

  EndpointId writer = 0;
  std::uint64_t sequence = 0;
  std::int64_t source_stamp_ns = 0;
  std::uint64_t diverted_sequence = 0;  ///< meaningless for a sample that came by UDP
  std::int64_t diverted_stamp_ns = 0;

  // The following values are set for samples that were received by UDP. For samples in shared memory only
  // oldest_retained and the values of the gate with conditions that the sample has passed (gate_table.h)
  // are set.

  /// The maximum rate of the gate that the sample passed at its writer, as the minimum time between two
  /// samples in microseconds; 0: none.
  std::uint32_t min_period_us = 0;
  std::uint64_t gate = 0;     ///< the id of that gate if the gate has conditions (gate_id()), otherwise 0
  std::uint32_t ordinal = 0;  ///< the sample's number among those that passed the gate
  EndpointId addressee = 0;   ///< the only reader that the sample is for; 0: it is for all readers
  /// The sequence of the first retained sample that the writer has sent to the reader; 0: unknown.
  std::uint64_t oldest_retained = 0;
  /// The number of times that the numbering of the writer's samples has begun anew, because earlier sequences
  /// were implausible.
  std::uint32_t numbering = 0;
  bool merged = false;  ///< true: the mask is the union of the masks of several readers

  void trust(const detail::SampleHeader& header) noexcept {
    writer = header.writer;
    sequence = header.sequence;
    source_stamp_ns = header.source_stamp_ns;
    diverted_sequence = header.diverted_sequence;
    diverted_stamp_ns = header.diverted_stamp_ns;
  }
};

}  // namespace sft::core
