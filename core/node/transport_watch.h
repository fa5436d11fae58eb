// The state of a node's two transports: whether shared memory is available, on which host, where the node is
// reached by UDP, and what of this is written to the log. The agent's, except what is marked.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "core/negotiation/negotiation.h"
#include "core/platform/clock.h"
#include "core/report/node_log.h"
#include "core/seam/transport.h"

namespace sft::core {

class TransportWatch {
 public:
  /// All outlive this object; a transport is null if the node must not use it.
  TransportWatch(Transport* shm, Transport* udp, std::uint64_t network, NodeLog& log);

  const Self& self() const { return self_; }
  const std::vector<UdpAddress>& addresses() const { return addresses_; }
  const std::vector<Link>& links() const { return links_; }

  struct ShmChange {
    bool any = false;       ///< self() differs
    bool of_host = false;   ///< the ports of before are dead, and other ones may be opened
    bool of_state = false;  ///< for people
  };
  ShmChange look_at_shm(Time now);
  /// Writes the change that look_at_shm() has found last to the log.
  void log_shm();

  enum class NetworkChange : std::uint8_t {
    none,
    links,      ///< of links()
    addresses,  ///< of addresses(), and maybe of links()
  };
  /// Writes to the log if the transport has failed.
  NetworkChange look_at_udp(Time now);

  // Any thread.
  bool shm_ready() const { return shm_ready_.load(); }
  std::string shm_state() const;

 private:
  NetworkChange look_at_addresses(Time now);

  Transport* const shm_;
  Transport* const udp_;
  NodeLog& log_;
  Self self_;
  Availability shm_availability_ = Availability::starting;
  std::string shm_failure_;  ///< as it was written to the log last; empty while shared memory may come up
  bool shm_warned_ = false;
  bool udp_failed_ = false;
  std::vector<UdpAddress> addresses_;
  std::vector<Link> links_;
  Time next_look_at_addresses_{};

  std::atomic<bool> shm_ready_{false};
  mutable std::mutex shm_state_mutex_;
  std::string shm_state_ = "starting";  ///< guarded by shm_state_mutex_
};

}  // namespace sft::core
