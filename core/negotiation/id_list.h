// Functions for lists of ids, by which requests name the writers of a reader.
#pragma once

#include <algorithm>
#include <vector>

#include "core/control/control.h"

namespace sft::core {

inline bool holds(const std::vector<EndpointId>& ids, EndpointId id) {
  return std::ranges::find(ids, id) != ids.end();
}

}  // namespace sft::core
