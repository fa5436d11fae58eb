// Keeps which readers have got the retained samples of which durable writers, as far as the writer or the
// reader is ours. A reader that begins anew, or comes back after it was forgotten, is owed them again. Pure.
#pragma once

#include <cstdint>
#include <set>

#include "core/control/control.h"

namespace sft::core {

class HistoryState {
 public:
  /// All that our writer has sent to this reader alone has left. Counts once the reader's request says that
  /// it has begun to come. Returns true if that is news.
  bool given(EndpointId writer, const Endpoint& reader);
  /// All retained samples of that writer have arrived at our reader. Returns true if that is news.
  bool came(EndpointId reader, EndpointId writer) { return came_.insert({writer, reader}).second; }

  /// Returns the number of retained samples that the reader is still to get.
  std::uint32_t owed(const Endpoint& writer, const Endpoint& reader) const;
  /// Returns true if all retained samples of that writer have arrived at our reader.
  bool has_come(EndpointId reader, EndpointId writer) const { return came_.contains({writer, reader}); }

  /// A reader that lost a writer and found it again begins anew, although the writer may not have noticed:
  /// the reader is owed the history of each writer that its request does not name as begun.
  void begins_anew(const Endpoint& reader);
  /// Our reader does not hear that writer by one of the two paths any more.
  void disconnected(const Endpoint& reader, EndpointId writer);
  /// The endpoint is gone. What one of our readers has got of a writer that is gone counts until the reader
  /// is disconnected.
  void forget(EndpointId id);

 private:
  std::set<PairId> given_;  ///< of our own writers
  std::set<PairId> came_;   ///< of our own readers
};

}  // namespace sft::core
