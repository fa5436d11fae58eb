// What others do to the table of endpoints, as far as somebody has to be told: they speak in the name of our
// endpoints, or announce more than there is room for. Says when ours are to be announced anew, and writes to
// the log, neither faster than is of use. The agent's.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/negotiation/negotiation.h"
#include "core/report/node_log.h"

namespace sft::core {

class ControlWatch {
 public:
  /// Both outlive it.
  ControlWatch(Negotiation& negotiation, NodeLog& log) : negotiation_(negotiation), log_(log) {}

  /// Endpoints of ours that are to be announced anew now.
  std::vector<EndpointId> take_contested(Now now);
  void tell_of_refusals(Now now);

 private:
  void complain(EndpointId ours, const std::string& how, std::size_t others);

  Negotiation& negotiation_;
  NodeLog& log_;
  std::map<EndpointId, std::string> contested_;    ///< and how
  std::map<std::string, std::uint64_t> refusals_;  ///< by the name of the node, not yet told
  Now take_back_at_{};                             ///< not before
  Now complain_at_{};
  Now tell_of_refusals_at_{};
};

}  // namespace sft::core
