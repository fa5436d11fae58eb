// Whether a process has a chunk in hand: whether it is just taking one through a port, delivering it or
// giving it back. For these moments a chunk can be in no list, or be counted too often; if a process is
// killed there it stays so. sftd looks for such chunks while nobody has one in hand (sftd/chunk_auditor.h).
//
// A count in the port itself: odd, and the owner has one in hand. It lies behind the name of the port's node,
// which iceoryx stores and does not use, and which ends long before.
#pragma once

#include <atomic>
#include <cstdint>

#include "shm_transport/host/chunk_slots.h"
#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

inline std::atomic<std::uint32_t>& hand_of(const iox::popo::BasePortData& port) noexcept {
  constexpr std::size_t offset = 96;
  static_assert(iox::NodeName_t::capacity() >= offset + sizeof(std::uint32_t));
  static_assert(alignof(iox::NodeName_t) >= alignof(std::uint32_t));
  return *reinterpret_cast<std::atomic<std::uint32_t>*>(const_cast<char*>(port.m_nodeName.c_str()) + offset);
}

/// While it exists. Of one port one at a time: the port's mutex is held meanwhile.
class ChunkInHand {
 public:
  explicit ChunkInHand(const iox::popo::BasePortData& port) noexcept
      : hand_(hand_of(port)), before_(hand_.load(std::memory_order_relaxed)) {
    hand_.store(before_ + 1, std::memory_order_relaxed);
    before_chunk_leaves();  // or anything else of it is written
  }
  ~ChunkInHand() { hand_.store(before_ + 2, std::memory_order_release); }
  ChunkInHand(const ChunkInHand&) = delete;
  ChunkInHand& operator=(const ChunkInHand&) = delete;

 private:
  std::atomic<std::uint32_t>& hand_;
  const std::uint32_t before_;
};

}  // namespace sft::shm
