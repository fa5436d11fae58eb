// Opens locks in shared memory that a dead process left closed.
//
// iceoryx keeps a mutex in each port: a publisher holds its own, and that of each queue it puts a chunk into,
// while it delivers. If it is killed in between, the daemon blocks on that mutex for good the next time it
// changes the port's connections, and nobody can register any more; and it would abort on destroying a port
// whose mutex is locked.
//
// Opening such a lock by force is safe. First, only dead processes can have held it: the publisher, for its
// own lock as for those of the queues it feeds (readers only look, see port_lock.h); that none of the
// daemon's threads is its holder is checked. Second, the dead holder left nothing half done under it: what
// the mutexes guard (a publisher's list of queues, a queue's condition variable) is written by the daemon
// only, and chunks in queues are in lock-free structures.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "shm_transport/host/port_lock.h"
#include "shm_transport/sftd/client_table.h"
#include "shm_transport/sftd/log.h"

namespace iox::roudi {
class PortPool;
}

namespace sft::shm {

class LockHealer {
 public:
  LockHealer(iox::roudi::PortPool& ports, const ClientTable& clients, const Log& log)
      : ports_(ports), clients_(clients), log_(log) {}

  /// Notes which ports there are. The caller keeps the daemon's threads from changing them meanwhile.
  void note_ports();

  /// Opens what dead processes left locked. False if it must look again first (in 20 ms). Any thread; also
  /// while a thread of the daemon is blocked on such a lock.
  bool heal();

  std::uint64_t opened() const { return opened_.load(std::memory_order_relaxed); }

 private:
  using Clock = std::chrono::steady_clock;
  using Lock = PortLock;
  struct KnownPort {
    const iox::popo::BasePortData* port;
    const Lock* lock;
    iox::RuntimeName_t owner;  ///< copied: the port may be destroyed, and its place be used for another
    iox::capro::ServiceDescription service;
    bool is_publisher;
  };
  struct Suspect {
    int holder = 0;
    int looks = 0;  ///< at which it was the same one
    Clock::time_point last_look{};
  };
  enum class Finding { in_order, opened, unclear };
  Finding look_at(const KnownPort& port, Clock::time_point now);
  bool holder_is_dead(const KnownPort& port) const;
  bool is_settled(const Lock* lock, int holder, Clock::time_point now);

  iox::roudi::PortPool& ports_;
  const ClientTable& clients_;
  const Log& log_;

  std::atomic<std::uint64_t> opened_{0};

  std::mutex mutex_;              // guards what follows; held for a whole round, of which no call blocks
  std::vector<KnownPort> known_;  ///< subscribers first
  /// Closed locks of the dead that may yet be held by a thread of the daemon.
  std::map<const Lock*, Suspect> suspects_;
};

}  // namespace sft::shm
