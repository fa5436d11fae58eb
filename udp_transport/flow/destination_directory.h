// All destinations of a transport. Writers that send to the same remote socket share one destination.
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

  /// Returns the destination of that address. If there is none, connects a new one and asks the kernel for
  /// the path's MTU. If address.node is set, the destination that is already known for that node moves to
  /// this address. A destination is destroyed, with its connections, when no writer uses it any more.
  std::shared_ptr<Destination> find(const core::UdpAddress& address);
  /// Returns the destination whose reports carry the number `flow`; null if it does not exist any more.
  std::shared_ptr<Destination> of_flow(std::uint32_t flow);

  /// Maintains all known destinations. `anew` is true if routes or our own addresses have changed. Adds to
  /// `remarks` the limits of the length of datagrams that were found or have ended.
  void look_after(PathMtu::Time now, bool anew, std::vector<core::Network::Remark>& remarks);

 private:
  /// The node and the port if the address names its node, because a node may have several addresses.
  /// Otherwise the IP address and the port.
  using Key = std::pair<std::uint64_t, SocketAddress>;
  static Key key_of(const core::UdpAddress& address);
  std::uint32_t first_channel(const Key& key) const;
  std::shared_ptr<Destination> known(const core::UdpAddress& address) SFT_REQUIRES(mutex_);
  std::uint32_t unused_flow() SFT_REQUIRES(mutex_);

  const DestinationLimits limits_;
  const Connect connect_;
  const HashKey channel_key_;
  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  std::map<Key, std::weak_ptr<Destination>> known_ SFT_GUARDED_BY(mutex_);
  UnprovenBudgets hosts_ SFT_GUARDED_BY(mutex_);
  /// The destinations of the present call of look_after().
  std::vector<std::shared_ptr<Destination>> looked_after_;
};

}  // namespace sft::udp
