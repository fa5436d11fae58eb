// The mutex in each of iceoryx's ports, looked at without being taken.
//
// A process killed while it holds one leaves it closed. sftd opens what writers left so (sftd/lock_healer.h),
// and relies on it that nobody else ever holds one: whoever only wants to know looks here.
#pragma once

#include <pthread.h>

#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

using PortLock = iox::popo::ThreadSafePolicy;

/// It is iceoryx's only member there; glibc's layout of it is part of the ABI of process-shared mutexes.
inline pthread_mutex_t& mutex_of(const PortLock& lock) noexcept {
  static_assert(sizeof(PortLock) >= sizeof(pthread_mutex_t));
  return *reinterpret_cast<pthread_mutex_t*>(const_cast<PortLock*>(&lock));
}

inline bool is_closed(const PortLock& lock) noexcept {
  return __atomic_load_n(&mutex_of(lock).__data.__lock, __ATOMIC_ACQUIRE) != 0;
}

/// The holder's thread id, in its own pid namespace; 0 while there is none, and for an instant when there is.
inline int holder_of(const PortLock& lock) noexcept {
  return __atomic_load_n(&mutex_of(lock).__data.__owner, __ATOMIC_ACQUIRE);
}

}  // namespace sft::shm
