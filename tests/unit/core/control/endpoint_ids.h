// Sets of a few endpoints, in the order in which requests list them.
#pragma once

#include <algorithm>
#include <vector>

#include "core/seam/transport.h"

namespace sft::test {

inline bool holds(const std::vector<core::EndpointId>& ids, core::EndpointId id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

inline void insert(std::vector<core::EndpointId>& ids, core::EndpointId id) {
  if (!holds(ids, id)) ids.push_back(id);
}

}  // namespace sft::test
