// The keys under which a link writes what the endpoints of the process announce and ask for. Cyclone DDS 0.10
// keeps 0.7 to 2 kB for each key that a reliable, transient-local writer was ever given, until the writer
// ends, however the instance ended. So a key that is not in use any more is used again. Pure, one thread at a
// time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/control/control.h"
#include "core/platform/random_id.h"

namespace sft::core {

class OwnKeys {
 public:
  /// Returns the key that the endpoint has until release(). No other process has this key, since each new key
  /// is a random number.
  std::uint64_t key_of(EndpointId id) {
    const auto [entry, is_new] = in_use_.try_emplace(id, 0);
    if (!is_new) return entry->second;
    if (free_.empty()) return entry->second = random_id();
    entry->second = free_.back();
    free_.pop_back();
    return entry->second;
  }
  /// Frees the key of the endpoint for the next endpoint, and returns it. Returns nothing if there is none.
  std::optional<std::uint64_t> release(EndpointId id) {
    const auto released = in_use_.extract(id);
    if (!released) return std::nullopt;
    free_.push_back(released.mapped());
    return released.mapped();
  }

 private:
  std::map<EndpointId, std::uint64_t> in_use_;
  std::vector<std::uint64_t> free_;
};

}  // namespace sft::core
