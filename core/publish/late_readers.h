// Sends late readers the samples that the publisher has retained, before they get the samples that are
// published later.
//
// A late reader gets retained samples from this class, and samples that are published meanwhile from its
// port. Over the network, the port queues samples for the late reader from set_routes() on, until the
// retained ones are sent. In shared memory, the port holds such samples back. They are in the history when
// the history is read, because the publisher puts each sample into the history before it reads its outlets.
// Samples that are sent by earlier routes or outlets do not reach the late reader, but are in the history,
// too. If a sample arrives in both ways, the reader takes it only once.
//
// The agent's thread calls all functions except missed().
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
  /// `network` is null if the publisher must not use the network. `history` is null if the publisher
  /// retains no samples; otherwise it must outlive this object.
  LateReaders(const TypeSupport& type, std::shared_ptr<NetworkWriter> network,
              std::shared_ptr<DeliveryBook> book, History* history);

  /// Serves the late readers in `serving`, whose routes must be in force. `memory` is null while there is no
  /// shared memory.
  void serve(const Serving& serving, std::shared_ptr<LendingWriter> memory);
  /// Sends the history to late readers in shared memory that are attached and wait for it. Must be called
  /// now and then.
  void give_history();
  /// Returns true if all retained samples that were sent to this late reader by UDP have left this process.
  bool history_sent(EndpointId reader) const { return network_ == nullptr || network_->history_sent(reader); }

  /// Returns the number of retained samples that were not sent, because shared memory had no free memory
  /// for them. Any thread may call this.
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
  /// The address of each reader to which the history was sent over the network.
  std::map<EndpointId, Locator> begun_;
  std::shared_ptr<LendingWriter> memory_;
  /// The routes to readers to which the history still has to be sent in shared memory.
  std::vector<Route> late_in_memory_;
  std::atomic<std::uint64_t> missed_{0};
};

}  // namespace sft::core
