#include "shm_transport/sftd/lock_healer.h"

#include <linux/futex.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>

#include <iceoryx_posh/roudi/port_pool.hpp>

namespace sft::shm {

namespace {

/// The mutex is iceoryx's only member there; glibc's layout of it is part of the ABI of process-shared
/// mutexes.
pthread_mutex_t& mutex_of(const iox::popo::ThreadSafePolicy& lock) {
  static_assert(sizeof(iox::popo::ThreadSafePolicy) >= sizeof(pthread_mutex_t));
  return *reinterpret_cast<pthread_mutex_t*>(const_cast<iox::popo::ThreadSafePolicy*>(&lock));
}

bool is_closed(const iox::popo::ThreadSafePolicy& lock) {
  return __atomic_load_n(&mutex_of(lock).__data.__lock, __ATOMIC_ACQUIRE) != 0;
}

int holder_of(const iox::popo::ThreadSafePolicy& lock) {
  return __atomic_load_n(&mutex_of(lock).__data.__owner, __ATOMIC_ACQUIRE);
}

bool is_own_thread(int thread) {
  return access(("/proc/self/task/" + std::to_string(thread)).c_str(), F_OK) == 0;
}

/// As pthread_mutex_unlock would for the holder. The word goes last: from then on another thread may be in.
void open_by_force(const iox::popo::ThreadSafePolicy& lock) {
  auto& data = mutex_of(lock).__data;
  data.__count = 0;
  data.__nusers = 0;
  __atomic_store_n(&data.__owner, 0, __ATOMIC_RELAXED);
  __atomic_store_n(&data.__lock, 0, __ATOMIC_RELEASE);
  syscall(SYS_futex, &data.__lock, FUTEX_WAKE, 1, nullptr, nullptr, 0);
}

}  // namespace

void LockHealer::note_ports() {
  std::vector<KnownPort> ports;
  for (const auto* port : ports_.getSubscriberPortDataList()) {
    ports.push_back(
        {port, &port->m_chunkReceiverData, port->m_runtimeName, port->m_serviceDescription, false});
  }
  for (const auto* port : ports_.getPublisherPortDataList()) {
    ports.push_back({port, &port->m_chunkSenderData, port->m_runtimeName, port->m_serviceDescription, true});
  }
  const std::scoped_lock lock(mutex_);
  known_.swap(ports);
}

/// Queues before publishers: as soon as a publisher's lock is open, a thread of the daemon that waits for it
/// goes on and may destroy a port with such a queue.
bool LockHealer::heal() {
  const auto now = Clock::now();
  const std::scoped_lock lock(mutex_);
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

LockHealer::Finding LockHealer::look_at(const KnownPort& known, Clock::time_point now) {
  if (!is_closed(*known.lock)) {
    unowned_.erase(known.lock);
    return Finding::in_order;
  }
  const int holder = holder_of(*known.lock);
  if (is_own_thread(holder) || !holder_is_dead(known)) return Finding::in_order;
  if (!is_settled(known.lock, holder, now)) return Finding::unclear;
  open_by_force(*known.lock);
  unowned_.erase(known.lock);
  log_.info(std::string("opened a lock that a killed process left closed, on a port of ") +
            known.owner.c_str());
  return Finding::opened;
}

/// A lock has no holder for an instant, between two instructions of taking or releasing it: when its holder
/// was killed right there, or in a living thread of the daemon, which has moved on a moment later.
bool LockHealer::is_settled(const Lock* lock, int holder, Clock::time_point now) {
  if (holder != 0) return true;
  return now - unowned_.try_emplace(lock, now).first->second >= std::chrono::milliseconds(20);
}

bool LockHealer::holder_is_dead(const KnownPort& known) const {
  // Not the port that was noted: another one in its place, and nothing is known of that.
  if (known.port->m_runtimeName != known.owner) return false;
  if (known.is_publisher) return clients_.is_gone(known.owner.c_str());
  return std::ranges::all_of(known_, [&](const KnownPort& other) {
    const bool feeds = other.is_publisher && other.service == known.service;
    return !feeds || clients_.is_gone(other.owner.c_str());
  });
}

}  // namespace sft::shm
