// The writers and readers of one node, by id. Used by the agent only.
#pragma once

#include <map>

#include "core/node/local_reader.h"
#include "core/node/local_writer.h"

namespace sft::core {

struct LocalEndpoints {
  std::map<EndpointId, LocalWriter> writers;
  std::map<EndpointId, LocalReader> readers;
};

}  // namespace sft::core
