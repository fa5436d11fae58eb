// iceoryx's pools as they lie in shared memory, where all of this is private: which places of a pool are
// free, and how one is freed that its last user could not free.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

/// One pool. What its programs may have written there is checked.
class PoolLayout {
 public:
  /// `pool` outlives this, and no program has been let in yet.
  explicit PoolLayout(iox::mepoo::MemPool& pool);

  std::uint32_t places() const { return places_; }
  std::byte* at(std::uint32_t place) const { return begin_ + std::size_t{place} * place_bytes_; }
  std::optional<std::uint32_t> place_of(const void* address) const;

  /// By place. Only right if nobody takes or frees one meanwhile; empty if the list is broken.
  std::vector<bool> free_places() const;
  /// How many places the pool believes to be taken beyond those that are.
  std::int64_t counted_too_many(const std::vector<bool>& free) const;

  /// Others may use the pool meanwhile.
  void correct_count(std::int64_t too_many);
  /// One that is taken, and nobody's.
  void free(std::uint32_t place);

 private:
  iox::mepoo::MemPool& pool_;
  std::byte* const begin_;
  const std::uint32_t place_bytes_;
  const std::uint32_t places_;
  std::uint32_t* const next_free_;  ///< by place
};

/// Those that chunks come from, and behind them the one of their headers (iox::mepoo::ChunkManagement).
std::vector<PoolLayout> pools_of(iox::mepoo::MemoryManager& memory);

}  // namespace sft::shm
