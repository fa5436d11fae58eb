// Reads the pools of iceoryx from shared memory to find the free chunks of a pool. Also frees a chunk that
// its last user could not free. The data is in private members of iceoryx's classes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

/// One pool. Its chunks are numbered from 0 on. Programs can write into the pool, so every value that is
/// read from the pool is checked. The values that the constructor reads are checked only by is_within().
class PoolLayout {
 public:
  /// `pool` must outlive this object. When the daemon constructs it, no program can write into the pool
  /// yet.
  explicit PoolLayout(iox::mepoo::MemPool& pool);

  std::uint32_t chunk_count() const { return chunk_count_; }
  std::uint32_t chunk_bytes() const { return chunk_bytes_; }
  std::byte* at(std::uint32_t index) const { return begin_ + std::size_t{index} * chunk_bytes_; }
  /// Returns whether the chunks are within `samples`, and the list of the free chunks within `management`.
  bool is_within(std::span<const std::byte> samples, std::span<const std::byte> management) const;
  std::optional<std::uint32_t> index_of(const void* address) const;

  /// Returns for each index whether the chunk is free. Returns nothing if the list of free chunks is
  /// damaged: if it leads to a chunk that does not exist or is taken, or twice to the same chunk. The
  /// result is valid only if no process takes or frees a chunk during the call.
  std::optional<std::vector<bool>> free_chunks() const;
  /// Writes the indices of the chunks that will be lent next into `chunks`, in order, and returns their
  /// number. If a process takes or frees a chunk during the call, other chunks may be lent next. Every
  /// index in the result is that of an existing chunk.
  std::size_t next_free(std::span<std::uint32_t> chunks) const;
  /// Returns the difference between the pool's count of taken chunks and the number of chunks that are
  /// really taken.
  std::int64_t overcount(const std::vector<bool>& free) const;

  /// Lowers the pool's count of taken chunks by `too_many`. Programs may use the pool meanwhile.
  void correct_count(std::int64_t too_many);
  /// Frees a chunk that counts as taken, but that no process has.
  void free(std::uint32_t index);

 private:
  iox::mepoo::MemPool& pool_;
  std::byte* const begin_;
  const std::uint32_t chunk_bytes_;
  const std::uint32_t chunk_count_;
  std::uint32_t* const next_free_;  ///< by index: the free chunk that follows each free chunk
};

/// Returns the pools of chunks, followed by the pool of the headers of chunks
/// (iox::mepoo::ChunkManagement).
std::vector<PoolLayout> pools_of(iox::mepoo::MemoryManager& memory);

}  // namespace sft::shm
