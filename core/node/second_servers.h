// Finds services of this node that another node serves, too: clients call no server then. A server that was
// killed still seems to exist for a moment after its successor has started. So a second server counts only
// once it has been there for a while. Uses no clock, thread or I/O.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "core/negotiation/endpoint_table.h"
#include "core/node/misspelt_topics.h"
#include "core/platform/clock.h"

namespace sft::core {

class SecondServers {
 public:
  /// Returns a sentence for each such service, at most once in some seconds. For `publishers_of` see
  /// Discovery::publishers_of().
  std::vector<std::string> look(const EndpointTable& table, const MisspeltTopics::PublishersOf& publishers_of,
                                Time now);

 private:
  std::set<std::string> found_;  ///< the sentences about the services with two servers at the last look
  Time next_{};
};

}  // namespace sft::core
