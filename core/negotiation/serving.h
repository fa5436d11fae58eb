// The desired state of one of our writers: which samples it should send to which readers.
// Negotiation::serving() derives it.
#pragma once

#include <vector>

#include "core/seam/transport.h"
#include "sft/status.h"

namespace sft::core {

struct Serving {
  bool memory_port = false;  ///< the writer needs a port to shared memory, even if no reader is attached yet
  std::vector<Route> memory;
  std::vector<Route> network;
  /// Routes over the network for samples that shared memory does not take. They lead to those readers of
  /// `memory` that also accept samples over the network.
  std::vector<Route> fallback;
  std::vector<Route>
      unreached;  ///< routes that are not in `memory` only because the port cannot notify their readers
  std::vector<PublisherStatus::Reader> readers;  ///< the status of all readers of the topic, with reasons
  bool lease_requested = false;                  ///< at least one reader requests a lease
  bool samples_assert = true;                    ///< each reader that requests a lease gets every sample
  bool history_owed = false;                     ///< at least one route has retained samples to send

  /// Returns true if both states have the same routes. The status of the readers may differ.
  bool serves_like(const Serving& other) const {
    return memory_port == other.memory_port && memory == other.memory && network == other.network &&
           fallback == other.fallback;
  }
  friend bool operator==(const Serving&, const Serving&) = default;
};

}  // namespace sft::core
