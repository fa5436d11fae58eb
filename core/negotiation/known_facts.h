// All facts from which the negotiation derives the desired states: this host, the endpoints, and what is
// known of pairs of them. The facts about an endpoint that is gone are removed. Uses no clock, thread or
// I/O.
#pragma once

#include "core/negotiation/endpoint_table.h"
#include "core/negotiation/history_state.h"
#include "core/negotiation/local_host.h"
#include "core/negotiation/requested_selections.h"
#include "core/negotiation/unreachable_readers.h"

namespace sft::core {

struct KnownFacts {
  LocalHost host{};
  EndpointTable table{};
  HistoryState history{};
  UnreachableReaders unreachable{};
  mutable RequestedSelections requested{};  ///< decoded from the requests in the table

  /// Removes an endpoint. If the endpoint comes back later, it must get the history again.
  void erase(EndpointId id) {
    if (!table.erase(id)) return;
    history.forget(id);
    unreachable.forget(id);
    requested.forget(id);
  }
};

}  // namespace sft::core
