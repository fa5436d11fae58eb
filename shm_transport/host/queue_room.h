// Lets a writer sleep until its reader has freed a place in the queue. Writer and reader use one word in
// the reader's port, next to the count of chunk_hand.h. The writer stores in the word that it waits, checks
// the queue once more, and sleeps on the word (a futex). The reader checks the word after it has taken a
// sample, and wakes the writer. Both sides use a full fence between their two steps, so that at least one
// side notices the action of the other side.
//
// A reader that is killed wakes no writer. So a writer never sleeps long before it checks whether the queue
// still exists.
#pragma once

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>

#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

#ifndef __clang__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wtsan"
#endif
inline void full_fence() noexcept { std::atomic_thread_fence(std::memory_order_seq_cst); }
#ifndef __clang__
#pragma GCC diagnostic pop
#endif

/// The word in a reader's port. The memory of the port must stay mapped.
class QueueRoom {
 public:
  static constexpr std::size_t offset = 88;  ///< the word's position in the field for the node's name

  explicit QueueRoom(const iox::popo::BasePortData& port) noexcept : word_(word_of(port)) {}

  // The following functions are for the thread of the writer.

  /// Notes that the writer waits. The writer must check the queue once more after this call before it
  /// sleeps.
  void begin_waiting() noexcept {
    word_->store(writer_waits, std::memory_order_seq_cst);
    full_fence();
  }
  /// Sleeps until the reader has taken a sample, for `at_most` at most. May also return earlier without a
  /// reason.
  void sleep(std::chrono::nanoseconds at_most) noexcept {
    timespec timeout{};
    timeout.tv_sec = at_most.count() / 1'000'000'000;
    timeout.tv_nsec = at_most.count() % 1'000'000'000;
    syscall(SYS_futex, word_, FUTEX_WAIT, writer_waits, &timeout, nullptr, 0);
  }
  void end_waiting() noexcept { word_->store(nobody_waits, std::memory_order_relaxed); }

  // The following functions are for the threads of the reader.

  /// Returns whether the writer waits. Called by the reader after it has taken a sample.
  bool is_waited_for() const noexcept {
    full_fence();
    return word_->load(std::memory_order_relaxed) == writer_waits;
  }
  void wake() noexcept {
    if (word_->exchange(nobody_waits, std::memory_order_seq_cst) == writer_waits)
      syscall(SYS_futex, word_, FUTEX_WAKE, 1, nullptr, nullptr, 0);
  }

 private:
  static constexpr std::uint32_t nobody_waits = 0, writer_waits = 1;

  static std::atomic<std::uint32_t>* word_of(const iox::popo::BasePortData& port) noexcept {
    static_assert(iox::NodeName_t::capacity() >= offset + sizeof(std::uint32_t));
    static_assert(alignof(iox::NodeName_t) >= alignof(std::uint32_t));
    return reinterpret_cast<std::atomic<std::uint32_t>*>(const_cast<char*>(port.m_nodeName.c_str()) + offset);
  }

  std::atomic<std::uint32_t>* word_;
};

}  // namespace sft::shm
