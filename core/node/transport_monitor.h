// The state of a node's two transports: whether shared memory is available, on which host, where the node is
// reached by UDP, and what of this is written to the log. Used by the agent only, except what is marked.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "core/negotiation/negotiation.h"
#include "core/platform/clock.h"
#include "core/report/node_log.h"
#include "core/seam/transport.h"
#include "core/sync/mutex.h"

namespace sft::core {

class TransportMonitor {
 public:
  /// All outlive this object; a transport is null if the node must not use it.
  TransportMonitor(SharedMemory* memory, Network* network, std::uint64_t network_id, NodeLog& log);

  const Self& self() const { return self_; }
  const std::vector<UdpAddress>& addresses() const { return addresses_; }
  const std::vector<Link>& links() const { return links_; }

  struct MemoryChange {
    bool any = false;         ///< self() has changed
    bool of_host = false;     ///< former ports are dead, and new ones may be opened
    bool of_state = false;    ///< the description for people
    bool of_failure = false;  ///< the reason that other nodes are told
  };
  MemoryChange look_at_memory(Time now);
  /// Logs the change that look_at_memory() found last.
  void log_memory();

  enum class NetworkChange : std::uint8_t {
    none,
    links,      ///< of links()
    addresses,  ///< of addresses(), and maybe of links()
  };
  /// Writes the remarks of the transport to the log, and logs its failure.
  NetworkChange look_at_network(Time now);
  /// Returns when a transport must be looked at again. Must be called after both were looked at.
  Time next_look(Time now) const;

  // Any thread.
  bool memory_ready() const { return memory_ready_.load(); }
  std::string memory_state() const;

 private:
  NetworkChange look_at_addresses(Time now);

  SharedMemory* const memory_;
  Network* const network_;
  NodeLog& log_;
  Self self_;
  Availability memory_availability_ = Availability::starting;
  std::string logged_failure_;  ///< the last one of shared memory in the log; empty while that may come up
  bool memory_warned_ = false;
  bool network_failed_ = false;
  std::vector<UdpAddress> addresses_;
  std::vector<Link> links_;
  Time next_look_at_addresses_{};

  std::atomic<bool> memory_ready_{false};
  mutable Mutex memory_state_mutex_;
  std::string memory_state_ SFT_GUARDED_BY(memory_state_mutex_) = "starting";
};

}  // namespace sft::core
