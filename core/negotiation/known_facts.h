// All facts from which the negotiation derives the desired states: this host, the endpoints, and what is
// noted of pairs of them. Nothing remains noted of an endpoint that is gone. Pure.
#pragma once

#include "core/negotiation/endpoint_table.h"
#include "core/negotiation/history_state.h"
#include "core/negotiation/local_host.h"
#include "core/negotiation/requested_selections.h"
#include "core/negotiation/unreachable_readers.h"

namespace sft::core {

struct KnownFacts {
  LocalHost host;
  EndpointTable table;
  HistoryState history;
  UnreachableReaders unreachable;
  mutable RequestedSelections requested{};  ///< follows from the requests in the table

  /// The endpoint is gone. If it comes back after this, it is owed the history again.
  void erase(EndpointId id) {
    if (!table.erase(id)) return;
    history.forget(id);
    unreachable.forget(id);
    requested.forget(id);
  }
};

}  // namespace sft::core
