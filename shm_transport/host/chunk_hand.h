// A process has a chunk in hand while it takes the chunk through a port, delivers it or gives it back.
// During that time the chunk can be in no list, or its count of references can be too high. If the process
// is killed during that time, the chunk stays in that state. sftd looks for such chunks while no process
// has a chunk in hand (sftd/chunk_auditor.h).
//
// The port itself shows whether a chunk is in hand, by a count. An odd count means that the owner of the
// port has a chunk in hand. The count is stored in the field for the name of the port's node, far beyond
// the end of the name. iceoryx stores this field and does not use it.
#pragma once

#include <atomic>
#include <cstdint>

#include "shm_transport/host/chunk_slots.h"
#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

inline std::atomic<std::uint32_t>& in_hand_count(const iox::popo::BasePortData& port) noexcept {
  constexpr std::size_t offset = 96;
  static_assert(iox::NodeName_t::capacity() >= offset + sizeof(std::uint32_t));
  static_assert(alignof(iox::NodeName_t) >= alignof(std::uint32_t));
  return *reinterpret_cast<std::atomic<std::uint32_t>*>(const_cast<char*>(port.m_nodeName.c_str()) + offset);
}

/// Returns whether the owner of the port has a chunk in hand, or was killed while it had one.
inline bool is_in_hand(const iox::popo::BasePortData& port) noexcept {
  return in_hand_count(port).load(std::memory_order_acquire) % 2 != 0;
}

/// Marks the port as having a chunk in hand, as long as this object exists. A port can have only one such
/// object at a time, so the caller must hold the mutex of the port.
class ChunkInHand {
 public:
  explicit ChunkInHand(const iox::popo::BasePortData& port) noexcept
      : hand_(in_hand_count(port)), before_(hand_.load(std::memory_order_relaxed)) {
    hand_.store(before_ + 1, std::memory_order_relaxed);
    before_chunk_leaves();  // the count is written before any other change
  }
  ~ChunkInHand() { hand_.store(before_ + 2, std::memory_order_release); }
  ChunkInHand(const ChunkInHand&) = delete;
  ChunkInHand& operator=(const ChunkInHand&) = delete;

 private:
  std::atomic<std::uint32_t>& hand_;
  const std::uint32_t before_;
};

}  // namespace sft::shm
