// Chooses the pool of the daemon from which a writer takes its next chunk. A writer requests only chunks
// that iceoryx can give. Otherwise iceoryx would print to the terminal of the program if the pool is empty,
// and would report an error of the whole process if the size exceeds all pools.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "shm_transport/host/iceoryx.h"
#include "shm_transport/host/prepared_chunks.h"

namespace sft::shm {

/// Returns the size to request from iceoryx, to get a chunk that holds at least `bytes`.
constexpr std::size_t payload_for(std::size_t bytes) { return (bytes + 7) / 8 * 8; }

/// All writers of a session share one object. Any thread may call the functions.
class ChunkPools {
 public:
  /// PreparedChunks explains `samples`, `management` and `file`. Without them no chunks are prepared.
  explicit ChunkPools(const iox::mepoo::MemoryManager& pools, std::span<const std::byte> samples = {},
                      std::span<const std::byte> management = {}, int file = -1)
      : pools_(pools), prepared_(pools, samples, management, file) {}

  struct Choice {
    std::uint32_t pool = 0;
    std::uint32_t payload_bytes = 0;  ///< the size to request from iceoryx to get a chunk of this pool
  };
  /// Returns the smallest pool whose chunks are large enough, or the next larger pool if the smallest of
  /// them is used up. Still larger pools are never chosen, so that a flood of small samples does not use up
  /// the large chunks.
  std::optional<Choice> choose(std::size_t bytes) const noexcept;

  /// Returns the number of bytes that a chunk of the largest pool holds.
  std::size_t largest_bytes() const noexcept;

  /// Notes that the chosen pool was empty although its count shows free chunks. A process that is killed
  /// while it takes a chunk can leave a chunk that counts as free but cannot be taken. Such chunks are not
  /// counted as free for one second. By then sftd has found them.
  void note_empty(const Choice& choice) noexcept;

  /// Notes that a writer got a chunk from the chosen pool, for a sample of `bytes`.
  void note_taken(const Choice& choice, std::size_t bytes) noexcept {
    prepared_.note(choice.pool, bytes + sizeof(iox::mepoo::ChunkHeader));
  }
  /// Calls PreparedChunks::set_aside(). `bytes` is the size that choose() got.
  bool set_aside(const iox::mepoo::ChunkHeader& chunk, std::size_t bytes) noexcept {
    return prepared_.set_aside(chunk, payload_for(bytes) + sizeof(iox::mepoo::ChunkHeader));
  }
  /// Calls PreparedChunks::prepare().
  void prepare() noexcept { prepared_.prepare(); }

 private:
  const iox::mepoo::MemoryManager& pools_;
  using Clock = std::chrono::steady_clock;
  /// The chunks of one pool that count as free but cannot be taken.
  struct Vanished {
    std::atomic<std::uint32_t> chunks{0};
    std::atomic<Clock::time_point> until{};  ///< the time until which `chunks` is valid
    std::uint32_t count() const noexcept;
  };
  std::array<Vanished, iox::MAX_NUMBER_OF_MEMPOOLS> vanished_{};
  PreparedChunks prepared_;
};

inline constexpr std::size_t chunk_header_size = sizeof(iox::mepoo::ChunkHeader);

}  // namespace sft::shm
