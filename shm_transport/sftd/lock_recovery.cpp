#include "shm_transport/sftd/lock_recovery.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>

#include <iceoryx_posh/roudi/port_pool.hpp>

namespace sft::shm {

namespace {

constexpr std::chrono::milliseconds look_interval{20};

bool is_own_thread(int thread) {
  return thread != 0 && access(("/proc/self/task/" + std::to_string(thread)).c_str(), F_OK) == 0;
}

/// Does what pthread_mutex_unlock() does for the holder. The lock word is cleared last, because another
/// thread may take the lock from then on.
void open_by_force(const PortLock& lock) {
  auto& data = mutex_of(lock).__data;
  data.__count = 0;
  data.__nusers = 0;
  __atomic_store_n(&data.__owner, 0, __ATOMIC_RELAXED);
  __atomic_store_n(&data.__lock, 0, __ATOMIC_RELEASE);
  syscall(SYS_futex, &data.__lock, FUTEX_WAKE, 1, nullptr, nullptr, 0);
}

}  // namespace

void LockRecovery::note_ports() {
  std::vector<KnownPort> ports;
  for (const auto* port : ports_.getSubscriberPortDataList()) {
    ports.push_back(
        {port, &port->m_chunkReceiverData, port->m_runtimeName, port->m_serviceDescription, false});
  }
  for (const auto* port : ports_.getPublisherPortDataList()) {
    ports.push_back({port, &port->m_chunkSenderData, port->m_runtimeName, port->m_serviceDescription, true});
  }
  const core::Lock lock(mutex_);
  known_.swap(ports);
}

/// Opens the locks of queues before those of publishers. As soon as the lock of a publisher is open, a
/// thread of the daemon that waits for it continues, and may destroy a port whose queue is still locked.
bool LockRecovery::recover() {
  const auto now = Clock::now();
  const core::Lock lock(mutex_);
  bool queues_are_clear = true;
  bool all_is_clear = true;
  for (const KnownPort& known : known_) {
    if (known.is_publisher && !queues_are_clear) continue;
    const bool clear = look_at(known, now) != Finding::unclear;
    if (!known.is_publisher) queues_are_clear &= clear;
    all_is_clear &= clear;
  }
  return all_is_clear;
}

LockRecovery::Finding LockRecovery::look_at(const KnownPort& known, Clock::time_point now) {
  if (!is_closed(*known.lock) || !holder_is_dead(known)) {
    suspects_.erase(known.lock);
    return Finding::in_order;
  }
  if (!is_confirmed(known, now)) return Finding::unclear;
  open_by_force(*known.lock);
  suspects_.erase(known.lock);
  ++opened_;
  log_.info(std::string("opened a lock that a killed process left closed, on a port of ") +
            known.owner.c_str());
  return Finding::opened;
}

/// Returns whether enough checks have found the same holder, so that the lock can be opened. In three
/// cases, one check does not show that the holder is dead. First, a closed lock has no holder between two
/// instructions that take or release it. Either the holder was killed between them, or a living thread of
/// the daemon is between them and continues a moment later. Second, the id of a holder that died in another
/// pid namespace can be the id of a thread of the daemon here. Third, the lock of a queue can be held by a
/// living writer that was not noted yet, because its port was created only just now. In all three cases, a
/// living holder releases the lock after microseconds. Checks are counted instead of time, because the
/// daemon may have been stopped between two checks.
bool LockRecovery::is_confirmed(const KnownPort& known, Clock::time_point now) {
  const int holder = holder_of(*known.lock);
  const int looks_needed = is_own_thread(holder) || !has_known_writer(known) ? 6 : holder == 0 ? 2 : 1;
  Suspect& suspect = suspects_[known.lock];
  if (suspect.looks == 0 || suspect.holder != holder) {
    suspect = {holder, 1, now};
  } else if (now - suspect.last_look >= look_interval) {
    ++suspect.looks;
    suspect.last_look = now;
  }
  return suspect.looks >= looks_needed;
}

bool LockRecovery::feeds(const KnownPort& writer, const KnownPort& queue) {
  return writer.is_publisher && writer.service == queue.service;
}

bool LockRecovery::holder_is_dead(const KnownPort& known) const {
  // If the owner has changed, this is not the port that was noted, but another port at the same address.
  if (known.port->m_runtimeName != known.owner) return false;
  if (known.is_publisher) return clients_.is_gone(known.owner.c_str());
  return std::ranges::all_of(known_, [&](const KnownPort& other) {
    return !feeds(other, known) || clients_.is_gone(other.owner.c_str());
  });
}

bool LockRecovery::has_known_writer(const KnownPort& known) const {
  return known.is_publisher ||
         std::ranges::any_of(known_, [&](const KnownPort& other) { return feeds(other, known); });
}

}  // namespace sft::shm
