// Opens locks in shared memory that a dead process left closed.
//
// iceoryx has a mutex in each port. While a publisher delivers, it holds its own mutex and that of each queue
// that it puts a chunk into. If the publisher is killed then, the daemon blocks on that mutex for ever when
// it next changes the connections of the port, and no program can register any more. The daemon would also
// abort when it destroys a port whose mutex is locked.
//
// It is safe to open such a lock by force. First, only a dead process can hold it: a publisher holds its own
// lock and those of the queues that it feeds, while readers only look (port_lock.h). The healer checks that
// no thread of the daemon is the holder. Second, the dead holder left no half-done change: only the daemon
// writes what these mutexes guard (the list of queues of a publisher, the condition variable of a queue), and
// chunks lie in lock-free queues.
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

  /// Notes which ports exist. The caller keeps the threads of the daemon from changing them meanwhile.
  void note_ports();

  /// Opens the locks that dead processes left closed. Returns false if it must look again before it can open
  /// a lock; the next look can be in 20 ms. Any thread may call it, also while a thread of the daemon blocks
  /// on such a lock.
  bool recover();

  std::uint64_t opened() const { return opened_.load(std::memory_order_relaxed); }

 private:
  using Clock = std::chrono::steady_clock;
  using Lock = PortLock;
  struct KnownPort {
    const iox::popo::BasePortData* port;
    const Lock* lock;
    iox::RuntimeName_t owner;  ///< a copy: the port may be destroyed, and its memory used again
    iox::capro::ServiceDescription service;
    bool is_publisher;
  };
  struct Suspect {
    int holder = 0;
    int looks = 0;  ///< how many looks have found this holder
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

  // Held for a whole recover(), in which no call blocks.
  core::Mutex mutex_;
  std::vector<KnownPort> known_ SFT_GUARDED_BY(mutex_);  ///< subscribers come first
  /// Closed locks that dead processes seem to hold, but that a thread of the daemon may hold.
  std::map<const Lock*, Suspect> suspects_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::shm
