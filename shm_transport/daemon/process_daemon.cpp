#include "shm_transport/daemon/process_daemon.h"

#include "core/sync/mutex.h"

namespace sft::shm {

std::shared_ptr<ProcessDaemon> ProcessDaemon::shared() {
  static core::Mutex mutex;
  static std::weak_ptr<ProcessDaemon> current SFT_GUARDED_BY(mutex);
  const core::Lock lock(mutex);
  std::shared_ptr<ProcessDaemon> daemon = current.lock();
  if (daemon == nullptr) {
    daemon.reset(new ProcessDaemon);
    current = daemon;
  }
  return daemon;
}

DaemonLink::State ProcessDaemon::advance(const ShmOptions& options, Clock::time_point now) {
  // The session gets a pointer to the runtime that keeps this whole object alive. If the session did not
  // keep it alive, a new ProcessDaemon with a link of its own could make a second session while the first
  // session still exists.
  return link_.advance(options, std::shared_ptr<IceoryxRuntime>(shared_from_this(), &runtime_), now);
}

}  // namespace sft::shm
