// Watches the table of endpoints for what the log has to name: others announce more than there is room for, a
// topic of ours may be misspelt, or somebody else serves a service of ours, too. Writes to the log no faster
// than is of use. The agent's.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "core/negotiation/negotiation.h"
#include "core/node/misspelt_topics.h"
#include "core/platform/clock.h"
#include "core/report/node_log.h"

namespace sft::core {

class ControlMonitor {
 public:
  /// Both outlive it.
  ControlMonitor(Negotiation& negotiation, NodeLog& log) : negotiation_(negotiation), log_(log) {}

  void log_refusals(Time now);

  /// A subscriber of ours was opened.
  void reader_added(EndpointId id, Time now) { misspelt_topics_.added(id, now); }
  void name_misspelt_topics(const MisspeltTopics::PublishersOf& publishers_of, Time now);
  /// Names services of ours that have had a second server for a while. One that was killed is there for a
  /// moment after its successor has come.
  void name_second_servers(const MisspeltTopics::PublishersOf& publishers_of, Time now);

 private:
  Negotiation& negotiation_;
  NodeLog& log_;
  std::map<std::string, std::uint64_t> refusals_;  ///< by the name of the node, not yet logged
  MisspeltTopics misspelt_topics_;
  std::set<std::string> second_servers_;  ///< what was found by the last look
  Time log_refusals_at_{};
  Time look_at_servers_at_{};
};

}  // namespace sft::core
