// Logs what is wrong in the table of endpoints: other nodes announce more than there is room for, or the name
// of one of our topics may be misspelt. Limits how often it writes to the log. Used by the agent only.
#pragma once

#include <cstdint>
#include <map>
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

 private:
  Negotiation& negotiation_;
  NodeLog& log_;
  std::map<std::string, std::uint64_t> refusals_;  ///< by the name of the node, not yet logged
  MisspeltTopics misspelt_topics_;
  Time log_refusals_at_{};
};

}  // namespace sft::core
