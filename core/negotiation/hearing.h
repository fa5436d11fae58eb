// Derives from the known facts which writers one of our readers should hear, and by which paths. Pure.
#pragma once

#include <cstdint>
#include <vector>

#include "core/negotiation/known_facts.h"
#include "core/negotiation/type_comparisons.h"
#include "core/seam/transport.h"
#include "sft/status.h"

namespace sft::core {

/// One writer that one of our readers should hear.
struct Hearing {
  Source source;
  Qos offered;
  std::uint32_t owed = 0;  ///< retained samples that should come first
  bool memory = false;     ///< connect to it in shared memory
  bool network = false;
  SubscriberStatus::Writer status;
};

/// `reader`: one of ours.
std::vector<Hearing> hearing_of(const TableEntry& reader, const KnownFacts& facts,
                                TypeComparisons& comparisons);

}  // namespace sft::core
