// The state of a node's two transports: whether shared memory is available, on which host, and the UDP
// addresses of the node. Writes changes to the log. Used by the agent only, except for functions that are
// marked.
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
  /// All arguments must outlive this object. A transport is null if the node must not use that transport.
  TransportMonitor(SharedMemory* memory, Network* network, std::uint64_t network_id, NodeLog& log);

  const Self& self() const { return self_; }
  const std::vector<UdpAddress>& addresses() const { return addresses_; }
  const std::vector<Link>& links() const { return links_; }

  struct MemoryChange {
    bool any = false;         ///< self() has changed
    bool of_host = false;     ///< the former ports are dead, and new ones may be opened
    bool of_state = false;    ///< the text about shared memory for people has changed
    bool of_failure = false;  ///< the reason of the failure, which is announced to other nodes, has changed
  };
  MemoryChange look_at_memory(Time now);
  /// Logs the change that the last look_at_memory() has found.
  void log_memory();

  enum class NetworkChange : std::uint8_t {
    none,
    links,      ///< links() has changed
    addresses,  ///< addresses() has changed, and maybe links()
  };
  /// Writes the remarks of the network to the log, and logs the failure of the network, if it has failed.
  NetworkChange look_at_network(Time now);
  /// Returns the time at which a transport must be looked at again. Must be called after look_at_memory()
  /// and look_at_network().
  Time next_look(Time now) const;

  // The functions for any thread.
  bool memory_ready() const { return memory_ready_.load(); }
  std::string memory_state() const;

 private:
  NetworkChange look_at_addresses(Time now);

  SharedMemory* const memory_;
  Network* const network_;
  NodeLog& log_;
  Self self_;
  Availability memory_availability_ = Availability::starting;
  /// The last failure of shared memory that was logged; empty while shared memory may still become
  /// available.
  std::string logged_failure_;
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
