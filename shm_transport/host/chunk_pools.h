// The daemon's pools of chunks as a writer chooses from them. It asks iceoryx only for what it can give: from
// an empty pool it would print to the program's terminal, and a size above all pools is an error of the whole
// process to it.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

/// Shared by all writers of a session. Any thread.
class ChunkPools {
 public:
  explicit ChunkPools(const iox::mepoo::MemoryManager& pools) : pools_(pools) {}

  struct Choice {
    std::uint32_t pool = 0;
    std::uint32_t payload_bytes = 0;  ///< to ask for, so that iceoryx takes that pool
  };
  /// The pool of that size, or where it is used up the next larger one; not more, so that a flood of small
  /// samples leaves the large chunks alone.
  std::optional<Choice> choose(std::size_t bytes) const noexcept;

  /// What a chunk of the largest pool holds.
  std::size_t largest_bytes() const noexcept;

  /// The chosen pool was empty after all. A process killed while it took a chunk leaves one that counts as
  /// free and is not; this is reckoned with for a second, until sftd has found it.
  void note_empty(const Choice& choice) noexcept;

 private:
  const iox::mepoo::MemoryManager& pools_;
  using Clock = std::chrono::steady_clock;
  struct Vanished {  ///< chunks of a pool
    std::atomic<std::uint32_t> chunks{0};
    std::atomic<Clock::time_point> until{};
    std::uint32_t now() const noexcept;
  };
  std::array<Vanished, iox::MAX_NUMBER_OF_MEMPOOLS> vanished_{};
};

/// What to ask iceoryx for to get at least so many bytes.
constexpr std::size_t payload_for(std::size_t bytes) { return (bytes + 7) / 8 * 8; }
inline constexpr std::size_t chunk_header_size = sizeof(iox::mepoo::ChunkHeader);

}  // namespace sft::shm
