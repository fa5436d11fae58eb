// Reads the state of the mutex in a port of iceoryx without taking the mutex.
//
// A process that is killed while it holds such a mutex leaves it closed. sftd opens the mutexes that killed
// writers left closed (sftd/lock_recovery.h). sftd relies on the rule that only writers and sftd ever hold
// such a mutex. So all other code uses the functions here, which only read the state.
#pragma once

#include <pthread.h>

#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

using PortLock = iox::popo::ThreadSafePolicy;

/// The mutex is the only member of iceoryx's class. Its layout in glibc is part of the ABI of process-shared
/// mutexes.
inline pthread_mutex_t& mutex_of(const PortLock& lock) noexcept {
  static_assert(sizeof(PortLock) >= sizeof(pthread_mutex_t));
  return *reinterpret_cast<pthread_mutex_t*>(const_cast<PortLock*>(&lock));
}

inline bool is_closed(const PortLock& lock) noexcept {
  return __atomic_load_n(&mutex_of(lock).__data.__lock, __ATOMIC_ACQUIRE) != 0;
}

/// Returns the thread id of the holder, in the holder's pid namespace. Returns 0 if there is no holder, and
/// also for an instant while a thread takes or releases the mutex.
inline int holder_of(const PortLock& lock) noexcept {
  return __atomic_load_n(&mutex_of(lock).__data.__owner, __ATOMIC_ACQUIRE);
}

}  // namespace sft::shm
