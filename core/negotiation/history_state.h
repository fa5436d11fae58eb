// Records which readers have received the retained samples of which durable writers, for pairs whose writer
// or reader is ours. A reader that begins anew, or comes back after its endpoint was removed, must get
// these samples again. Uses no clock, thread or I/O.
#pragma once

#include <cstdint>
#include <set>

#include "core/control/control.h"

namespace sft::core {

class HistoryState {
 public:
  /// Called when all samples that our writer sends to this reader alone have left this process. Has an
  /// effect only if the reader's request says that the first of these samples has arrived (Request::begun).
  /// Returns true if the state has changed.
  bool given(EndpointId writer, const Endpoint& reader);
  /// Called when all retained samples of that writer have arrived at our reader. Returns true if the state
  /// has changed.
  bool came(EndpointId reader, EndpointId writer) { return came_.insert({writer, reader}).second; }

  /// Returns the number of retained samples that the reader still has to receive.
  std::uint32_t owed(const Endpoint& writer, const Endpoint& reader) const;
  /// Returns true if all retained samples of that writer have arrived at our reader.
  bool has_come(EndpointId reader, EndpointId writer) const { return came_.contains({writer, reader}); }

  /// Called for each request of a reader. A reader that has lost a writer and found it again begins anew,
  /// and the writer might not have noticed this. So each writer that the request does not name in `begun`
  /// must send its history to the reader again.
  void begins_anew(const Endpoint& reader);
  /// Called when our reader no longer receives from that writer by one of the two paths.
  void disconnected(const Endpoint& reader, EndpointId writer);
  /// Called when the endpoint is gone. If the endpoint is a writer, our readers still count as having its
  /// history until they are disconnected.
  void forget(EndpointId id);

 private:
  std::set<PairId> given_;  ///< pairs of our writers that have sent the history
  std::set<PairId> came_;   ///< pairs of our readers that have received the history
};

}  // namespace sft::core
