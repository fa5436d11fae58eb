// Logs what is wrong in the table of endpoints: other nodes announce more than there is room for, the name of
// one of our topics may be misspelt, or another node serves a service of ours, too. Limits how often it
// writes to the log. Used by the agent only.
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
  /// Both arguments outlive this object.
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
