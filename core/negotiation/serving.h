// Derives from the known facts what one of our writers should send to whom. Pure.
#pragma once

#include <vector>

#include "core/negotiation/known_facts.h"
#include "core/negotiation/type_comparisons.h"
#include "core/seam/transport.h"
#include "sft/status.h"

namespace sft::core {

/// The desired state of one of our writers.
struct Serving {
  bool memory_port = false;  ///< be reachable in shared memory, even if no reader is attached yet
  std::vector<Route> memory;
  std::vector<Route> network;
  /// Over the network, to those of `memory` that listen there: for what does not go that way.
  std::vector<Route> fallback;
  std::vector<Route> unreached;  ///< would be in `memory`, but the port cannot tell these of samples
  std::vector<PublisherStatus::Reader> readers;  ///< all of the topic, with reasons
  bool lease_requested = false;                  ///< some reader wants to know whether the writer lives
  bool samples_assert = true;                    ///< and each of these gets every sample
  bool history_owed = false;                     ///< some route has a history

  /// Returns true if both send the same to the same readers. What status() tells of these readers may differ.
  bool serves_like(const Serving& other) const {
    return memory_port == other.memory_port && memory == other.memory && network == other.network &&
           fallback == other.fallback;
  }
  friend bool operator==(const Serving&, const Serving&) = default;
};

/// `writer`: one of ours.
Serving serving_of(const TableEntry& writer, const KnownFacts& facts, TypeComparisons& comparisons);

}  // namespace sft::core
