// Decides which request of a reader of another node is in force: the newest one that the reader's node can
// have sent. A request of a reader that is not there is kept until the reader is seen. Pure.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/control/control.h"
#include "core/negotiation/early_requests.h"

namespace sft::core {

class RemoteRequests {
 public:
  /// A request that is this much ahead of the last one counts only if the reader's own node sends it.
  static constexpr std::uint64_t jump_max = std::uint64_t{1} << 32;

  /// No more than `early_max` requests are kept for readers that are not there.
  explicit RemoteRequests(std::size_t early_max) : early_(early_max) {}

  /// Returns true if the request is in force now. Reordered and repeated requests change nothing, nor does a
  /// request that the reader's node cannot have sent, since nobody asks for something else so often.
  static bool adopt(Endpoint& reader, const Request& request);

  /// The reader is not there.
  void keep(const Request& request) { dropped_ += early_.keep(request) ? 1 : 0; }
  /// The reader is there: adopts what was kept for it.
  void adopt_early(Endpoint& reader);
  void forget(EndpointId reader) { early_.forget(reader); }

  /// Requests that were dropped because too many were kept.
  std::uint64_t dropped() const { return dropped_; }

 private:
  EarlyRequests early_;
  std::uint64_t dropped_ = 0;
};

}  // namespace sft::core
