// Logs problems in the table of endpoints: the name of a topic of this node may be misspelt, or another node
// serves a service of this node, too. Limits how often it writes to the log. Used by the agent only.
#pragma once

#include <set>
#include <string>

#include "core/negotiation/endpoint_table.h"
#include "core/node/misspelt_topics.h"
#include "core/platform/clock.h"
#include "core/report/node_log.h"

namespace sft::core {

class ControlMonitor {
 public:
  /// Both arguments must outlive this object.
  ControlMonitor(const EndpointTable& table, NodeLog& log) : table_(table), log_(log) {}

  /// Called when a subscriber of this node was opened.
  void reader_added(EndpointId id, Time now) { misspelt_topics_.added(id, now); }
  void name_misspelt_topics(const MisspeltTopics::PublishersOf& publishers_of, Time now);
  /// Logs the services of this node for which a second server has existed for a while. (A server that was
  /// killed still seems to exist for a moment after its successor has started.)
  void name_second_servers(const MisspeltTopics::PublishersOf& publishers_of, Time now);

 private:
  const EndpointTable& table_;
  NodeLog& log_;
  MisspeltTopics misspelt_topics_;
  std::set<std::string> second_servers_;  ///< the services with two servers that the last check has found
  Time look_at_servers_at_{};
};

}  // namespace sft::core
