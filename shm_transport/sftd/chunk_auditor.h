// Finds the chunks that killed programs left taken, and frees them.
//
// A program that is killed while it has a chunk in hand (chunk_hand.h) leaves references that are counted and
// that nobody has, a chunk without a header, or a wrong count of free ones. Nothing tells which. But looked
// at as a whole, at a moment at which no living program has a chunk in hand, the memory tells: a chunk that
// is taken has a header with references, and it was taken by a writer that is still there, or that still has
// readers: only these can have it. Whatever else is taken is lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "shm_transport/host/iceoryx.h"
#include "shm_transport/sftd/pool_layout.h"

namespace iox::roudi {
class PortPool;
}

namespace sft::shm {

/// Used by one thread at a time, which keeps ports from being created or destroyed meanwhile.
class ChunkAuditor {
 public:
  /// All outlive this. `memory` is configured.
  ChunkAuditor(iox::roudi::PortPool& ports, iox::mepoo::MemoryManager& memory);

  /// Notes which writers there are, before any of them is gone.
  void note_ports();

  /// Frees what is lost by now, and returns how many chunks that were. Nothing if some program had a chunk in
  /// hand each time it looked, or the memory is not in order.
  std::optional<std::size_t> audit();

 private:
  struct Lost {
    std::vector<std::vector<std::uint32_t>> places;  ///< by pool; last the headers
    std::vector<std::int64_t> counted_too_many;      ///< likewise
  };
  using Hands = std::vector<std::uint32_t>;
  using Places = std::vector<std::vector<bool>>;  ///< by pool
  std::optional<Lost> look() const;
  std::optional<Lost> find_lost() const;
  void add_owned(Places& in_order) const;
  Hands hands() const;
  bool is_owned(const std::byte* chunk) const;
  std::size_t free(const Lost& lost);

  iox::roudi::PortPool& ports_;
  std::vector<PoolLayout> pools_;  ///< of chunks, and last the one of headers
  /// Writers by their ids, which stand in their chunks: those that are there or have readers.
  std::map<std::uint64_t, iox::capro::ServiceDescription> writers_;
};

}  // namespace sft::shm
