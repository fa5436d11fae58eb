// Derives from the known facts which writers one of our readers should receive from, and by which paths. Uses
// no clock, thread or I/O.
#pragma once

#include <cstdint>
#include <vector>

#include "core/negotiation/known_facts.h"
#include "core/negotiation/type_comparisons.h"
#include "core/seam/transport.h"
#include "sft/status.h"

namespace sft::core {

/// One writer that one of our readers should receive from.
struct Hearing {
  Source source;
  Qos offered;
  std::uint32_t owed = 0;  ///< the number of retained samples that the writer should send before all others
  bool memory = false;     ///< true: connect to the writer in shared memory
  bool network = false;
  SubscriberStatus::Writer status;
};

/// Returns the writers that `reader`, which is one of ours, should receive from.
std::vector<Hearing> hearing_of(const TableEntry& reader, const KnownFacts& facts,
                                TypeComparisons& comparisons);

}  // namespace sft::core
