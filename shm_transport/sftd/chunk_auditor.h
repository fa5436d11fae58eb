// Finds the chunks that killed programs left taken, and frees them.
//
// A program that is killed while it has a chunk in hand (chunk_hand.h) can leave references that are
// counted but that no process has, a chunk without a header, or a wrong count of free chunks. No single
// place shows which chunks are lost. So the auditor examines the whole memory, at a moment at which no
// living program has a chunk in hand. At that moment, a chunk that is rightly taken has a header with
// references, and the writer that took it still exists or still has readers, because only these can have
// references to it. Every other chunk that is taken is lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "shm_transport/host/iceoryx.h"
#include "shm_transport/host/pool_layout.h"

namespace iox::roudi {
class PortPool;
}

namespace sft::shm {

/// An object must be used by only one thread at a time. During a call that thread must keep ports from being
/// created or destroyed.
class ChunkAuditor {
 public:
  /// Both arguments must outlive this object. `memory` must be configured already.
  ChunkAuditor(iox::roudi::PortPool& ports, iox::mepoo::MemoryManager& memory);

  /// Notes which writers exist. Must be called before any of these writers is gone.
  void note_ports();

  enum class Finding {
    busy,     ///< in each attempt, some program had a chunk in hand; nothing is known about lost chunks
    damaged,  ///< a list of free chunks is damaged, so that it does not show which chunks are lost
    audited,
  };
  struct Audit {
    Finding finding;
    std::size_t freed = 0;  ///< number of lost chunks that were freed
    bool operator==(const Audit&) const = default;
  };
  /// Frees the chunks that are lost at present.
  Audit audit();

 private:
  struct Lost {
    /// By pool: the indices of its chunks; the pool of headers comes last.
    std::vector<std::vector<std::uint32_t>> chunks;
    std::vector<std::int64_t> overcount;  ///< by pool: the result of PoolLayout::overcount()
  };
  using InHandCounts = std::vector<std::uint32_t>;
  /// By pool and index of the chunk: true if the chunk is free or has an owner. The others are lost.
  using ChunkMarks = std::vector<std::vector<bool>>;
  struct Look {
    Finding finding;
    Lost lost{};
  };
  Look look() const;
  Look find_lost() const;
  void mark_owned(ChunkMarks& accounted) const;
  InHandCounts in_hand_counts() const;
  bool is_owned(const std::byte* chunk) const;
  std::size_t free(const Lost& lost);

  iox::roudi::PortPool& ports_;
  std::vector<PoolLayout> pools_;  ///< the pools of chunks, and last the pool of headers
  /// The topics of the writers that exist or have readers, by the id that a writer stores in its chunks.
  std::map<std::uint64_t, iox::capro::ServiceDescription> writers_;
};

}  // namespace sft::shm
