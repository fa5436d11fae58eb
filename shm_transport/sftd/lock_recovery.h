// Opens locks in shared memory that a dead process left closed.
//
// iceoryx has a mutex in each port. While a publisher delivers, it holds its own mutex and that of each
// queue that it puts a chunk into. If the publisher is killed then, the daemon blocks on that mutex for
// ever when it next changes the connections of the port, and no program can register any more. The daemon
// would also abort when it destroys a port whose mutex is locked.
//
// It is safe to open such a lock by force, for two reasons. First, only a dead process can hold it: a
// publisher holds its own lock and those of the queues that it feeds, while readers only read the state
// (port_lock.h). LockRecovery checks that no thread of the daemon is the holder. Second, the dead holder
// left no incomplete change: only the daemon writes the data that these mutexes guard (the list of queues
// of a publisher, the condition variable of a queue), and chunks are in lock-free queues.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/sync/mutex.h"
#include "shm_transport/host/port_lock.h"
#include "shm_transport/sftd/client_table.h"
#include "shm_transport/sftd/log.h"

namespace iox::roudi {
class PortPool;
}

namespace sft::shm {

class LockRecovery {
 public:
  LockRecovery(iox::roudi::PortPool& ports, const ClientTable& clients, const Log& log)
      : ports_(ports), clients_(clients), log_(log) {}

  /// Notes which ports exist. During the call, the caller must keep the threads of the daemon from creating
  /// and destroying ports.
  void note_ports();

  /// Opens the locks that dead processes left closed. Returns false if a lock may be opened only after
  /// another check; the next call should come after 20 ms. Any thread may call this, even while a thread of
  /// the daemon blocks on such a lock.
  bool recover();

  std::uint64_t opened() const { return opened_.load(std::memory_order_relaxed); }

 private:
  using Clock = std::chrono::steady_clock;
  using Lock = PortLock;
  struct KnownPort {
    const iox::popo::BasePortData* port;
    const Lock* lock;
    iox::RuntimeName_t owner;  ///< a copy, because the port may be destroyed and its memory used again
    iox::capro::ServiceDescription service;
    bool is_publisher;
  };
  struct Suspect {
    int holder = 0;
    int looks = 0;  ///< number of checks that have found this holder
    Clock::time_point last_look{};
  };
  enum class Finding { in_order, opened, unclear };
  Finding look_at(const KnownPort& port, Clock::time_point now) SFT_REQUIRES(mutex_);
  static bool feeds(const KnownPort& writer, const KnownPort& queue);
  bool holder_is_dead(const KnownPort& port) const SFT_REQUIRES(mutex_);
  bool has_known_writer(const KnownPort& port) const SFT_REQUIRES(mutex_);
  bool is_confirmed(const KnownPort& port, Clock::time_point now) SFT_REQUIRES(mutex_);

  iox::roudi::PortPool& ports_;
  const ClientTable& clients_;
  const Log& log_;

  std::atomic<std::uint64_t> opened_{0};

  // Held during the whole of recover(), in which no call blocks.
  core::Mutex mutex_;
  std::vector<KnownPort> known_ SFT_GUARDED_BY(mutex_);  ///< noted ports; subscribers come first
  /// Closed locks whose holder seems to be a dead process, but may be a thread of the daemon.
  std::map<const Lock*, Suspect> suspects_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::shm
