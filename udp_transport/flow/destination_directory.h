// All destinations of a transport: writers that send to one remote socket share its destination.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "core/seam/address.h"
#include "core/seam/transport.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "udp_transport/flow/destination.h"
#include "udp_transport/flow/unproven_budget.h"
#include "udp_transport/wire/keyed_hash.h"

namespace sft::udp {

class DestinationDirectory {
 public:
  DestinationDirectory(const DestinationLimits& limits, Connect connect);

  /// The destination of that address, known or new: a new one is connected to, and the kernel asked for the
  /// path's MTU. Where the address says whose it is, a known one moves there. It goes, with its connection,
  /// when nobody sends there any more.
  std::shared_ptr<Destination> find(const core::UdpAddress& address);
  /// The one that reports by that number; null if there is none any more.
  std::shared_ptr<Destination> of_flow(std::uint32_t flow);

  /// Looks after all known destinations. `anew`: routes or own addresses have changed. Adds limits of the
  /// length of datagrams that were found, or are over, to the remarks.
  void look_after(PathMtu::Time now, bool anew, std::vector<core::Network::Remark>& remarks);

 private:
  /// One that has several addresses is known by its node and port, any other by its address.
  using Key = std::pair<std::uint64_t, SocketAddress>;
  static Key key_of(const core::UdpAddress& address);
  std::uint32_t first_channel(const Key& key) const;
  std::shared_ptr<Destination> known(const core::UdpAddress& address) SFT_REQUIRES(mutex_);
  std::uint32_t unused_flow() SFT_REQUIRES(mutex_);
  static void remark_limit(Destination& destination, std::vector<core::Network::Remark>& remarks);

  const DestinationLimits limits_;
  const Connect connect_;
  const HashKey channel_key_;
  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  std::map<Key, std::weak_ptr<Destination>> known_ SFT_GUARDED_BY(mutex_);
  UnprovenBudgets hosts_ SFT_GUARDED_BY(mutex_);
  std::vector<std::shared_ptr<Destination>> looked_after_;  ///< used by look_after()
};

}  // namespace sft::udp
