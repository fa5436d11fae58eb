#include "shm_transport/sftd/chunk_auditor.h"

#include <algorithm>
#include <set>
#include <utility>

#include <iceoryx_posh/internal/mepoo/chunk_management.hpp>
#include <iceoryx_posh/roudi/port_pool.hpp>

#include "shm_transport/host/chunk_hand.h"

namespace sft::shm {

using iox::mepoo::ChunkHeader;
using iox::mepoo::ChunkManagement;

namespace {

// Maximum number of looks at the memory in one audit; each look takes about 0.1 ms.
constexpr int looks_max = 10;

std::uint64_t id_of(const iox::popo::UniquePortId& id) {
  return static_cast<iox::popo::UniquePortId::value_type>(id);
}

bool is_odd(std::uint32_t hand) { return hand % 2 != 0; }

}  // namespace

ChunkAuditor::ChunkAuditor(iox::roudi::PortPool& ports, iox::mepoo::MemoryManager& memory)
    : ports_(ports), pools_(pools_of(memory)) {}

void ChunkAuditor::note_ports() {
  std::set<std::uint64_t> present;
  for (const auto* port : ports_.getPublisherPortDataList()) {
    present.insert(id_of(port->m_uniqueId));
    writers_.insert_or_assign(id_of(port->m_uniqueId), port->m_serviceDescription);
  }
  const auto readers = ports_.getSubscriberPortDataList();
  std::erase_if(writers_, [&](const auto& writer) {
    const auto reads = [&](const auto* reader) { return reader->m_serviceDescription == writer.second; };
    return !present.contains(writer.first) && std::ranges::none_of(readers, reads);
  });
}

ChunkAuditor::Audit ChunkAuditor::audit() {
  note_ports();
  for (int i = 0; i < looks_max; ++i) {
    const Look found = look();
    if (found.finding == Finding::audited) return {Finding::audited, free(found.lost)};
    if (found.finding == Finding::damaged) return {Finding::damaged};
  }
  return {Finding::busy};
}

/// Looks once for lost chunks. Programs continue to run during the look. If a program has had a chunk in
/// hand during the look, the result is invalid.
ChunkAuditor::Look ChunkAuditor::look() const {
  const InHandCounts before = in_hand_counts();
  if (std::ranges::any_of(before, is_odd)) return {Finding::busy};
  Look found = find_lost();
  return in_hand_counts() == before ? found : Look{Finding::busy};
}

/// Reads each count by adding zero to it. The addition is a release operation. Unlike a load, it keeps
/// earlier reads of the memory before it. A program that takes a chunk in hand later changes the count
/// after the addition. The processors that SFT runs on guarantee this order. C++ does not, because that
/// program acquires nothing.
ChunkAuditor::InHandCounts ChunkAuditor::in_hand_counts() const {
  InHandCounts counts;
  const auto read = [&counts](const iox::popo::BasePortData* port) {
    counts.push_back(in_hand_count(*port).fetch_add(0, std::memory_order_acq_rel));
  };
  std::ranges::for_each(ports_.getPublisherPortDataList(), read);
  std::ranges::for_each(ports_.getSubscriberPortDataList(), read);
  return counts;
}

ChunkAuditor::Look ChunkAuditor::find_lost() const {
  ChunkMarks accounted;
  Lost lost;
  for (const PoolLayout& pool : pools_) {
    auto free = pool.free_chunks();
    if (!free) return {Finding::damaged};
    accounted.push_back(std::move(*free));
    lost.overcount.push_back(pool.overcount(accounted.back()));
  }
  mark_owned(accounted);
  for (const std::vector<bool>& of_pool : accounted) {
    auto& lost_of_pool = lost.chunks.emplace_back();
    for (std::uint32_t i = 0; i < of_pool.size(); ++i) {
      if (!of_pool[i]) lost_of_pool.push_back(i);
    }
  }
  return {Finding::audited, std::move(lost)};
}

/// Marks each header that counts references. Also marks the header's chunk if a known writer took the
/// chunk. The free chunks must be marked already.
void ChunkAuditor::mark_owned(ChunkMarks& accounted) const {
  for (std::uint32_t i = 0; i < pools_.back().chunk_count(); ++i) {
    const auto& header = *reinterpret_cast<const ChunkManagement*>(pools_.back().at(i));
    if (accounted.back()[i] || header.m_referenceCounter.load(std::memory_order_relaxed) == 0) continue;
    for (std::size_t pool = 0; pool + 1 < pools_.size(); ++pool) {
      const auto chunk = pools_[pool].index_of(header.m_chunkHeader.get());
      if (!chunk || accounted[pool][*chunk] || !is_owned(pools_[pool].at(*chunk))) continue;
      accounted[pool][*chunk] = accounted.back()[i] = true;
    }
  }
}

/// Returns whether a known writer took the chunk. Call this only for a taken chunk to which a header
/// refers.
bool ChunkAuditor::is_owned(const std::byte* chunk) const {
  return writers_.contains(id_of(reinterpret_cast<const ChunkHeader*>(chunk)->originId()));
}

std::size_t ChunkAuditor::free(const Lost& lost) {
  std::size_t chunks = 0;
  for (std::size_t pool = 0; pool < pools_.size(); ++pool) {
    const bool is_of_headers = pool + 1 == pools_.size();
    pools_[pool].correct_count(lost.overcount[pool]);
    for (const std::uint32_t index : lost.chunks[pool]) {
      if (is_of_headers)
        reinterpret_cast<ChunkManagement*>(pools_[pool].at(index))->m_referenceCounter.store(0);
      pools_[pool].free(index);
    }
    if (!is_of_headers) chunks += lost.chunks[pool].size();
  }
  return chunks;
}

}  // namespace sft::shm
