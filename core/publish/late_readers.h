// Gives readers that come late what the publisher has retained, before they get what is sent from then on.
//
// A late reader gets retained samples from here, and samples that are published meanwhile from its port. Over
// the network these wait in the port from set_routes() on; in shared memory they are held back, and are in
// the history by the time that it is looked at, because a sample is in the history before the publisher looks
// for its outlets. What send() sends by earlier routes or outlets does not reach the late reader, but is in
// the history, too. Both may hold the same sample; the reader takes it once.
//
// The agent's thread calls everything, except missed().
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "core/negotiation/serving.h"
#include "core/publish/history.h"
#include "core/seam/delivery.h"
#include "core/seam/writer_port.h"

namespace sft::core {

class LateReaders {
 public:
  /// `network` is null if the publisher must not use it; `history` is null if the publisher retains nothing,
  /// and outlives this.
  LateReaders(const TypeSupport& type, std::shared_ptr<NetworkWriter> network,
              std::shared_ptr<DeliveryBook> book, History* history);

  /// Serves the late readers among these. The routes have to be in force. `memory` is null while there is no
  /// shared memory.
  void serve(const Serving& serving, std::shared_ptr<LendingWriter> memory);
  /// Gives the history to late readers in shared memory as soon as they can be given it. To be called now and
  /// then.
  void give_history();
  /// True if all has left that was for that reader alone.
  bool history_sent(EndpointId reader) const { return network_ == nullptr || network_->history_sent(reader); }

  /// Retained samples that shared memory had no room for. Any thread.
  std::uint64_t missed() const noexcept { return missed_.load(std::memory_order_relaxed); }

 private:
  std::vector<Route> take_latecomers(const Serving& serving);
  bool give_history(LendingWriter& memory, const Route& route);
  std::vector<SampleHandle> retained_for(const Route& route) const;
  std::vector<SampleHandle> retained_in(LendingWriter& memory, const Route& route);

  const TypeSupport& type_;
  const std::shared_ptr<NetworkWriter> network_;
  const std::shared_ptr<DeliveryBook> book_;
  History* const history_;
  std::map<EndpointId, Locator> begun_;  ///< readers that are being given it over the network, and where
  std::shared_ptr<LendingWriter> memory_;
  std::vector<Route> late_in_memory_;  ///< to readers that are, or will be, given it in shared memory
  std::atomic<std::uint64_t> missed_{0};
};

}  // namespace sft::core
