// The link of this process to its daemon. iceoryx allows one session for each process, so all nodes of the
// process share one ProcessDaemon by reference counting. This is the only global object of the transport.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "shm_transport/daemon/daemon_link.h"
#include "shm_transport/host/iceoryx_runtime.h"
#include "shm_transport/host/shm_options.h"

namespace sft::shm {

class ProcessDaemon : public std::enable_shared_from_this<ProcessDaemon> {
 public:
  /// Returns the object of this process. Creates the object if no node and no session holds it now. Any
  /// thread may call this.
  static std::shared_ptr<ProcessDaemon> shared();

  /// Advances the link, as DaemonLink::advance() describes. A session in the result keeps this object alive.
  DaemonLink::State advance(const ShmOptions& options, Clock::time_point now);
  std::string description() const { return link_.description(); }
  bool lacks_daemon() const { return link_.lacks_daemon(); }

 private:
  ProcessDaemon() = default;

  IceoryxRuntime runtime_;
  DaemonLink link_;
};

}  // namespace sft::shm
