#include "shm_transport/sftd/chunk_auditor.h"

#include <algorithm>
#include <set>

#include <iceoryx_posh/internal/mepoo/chunk_management.hpp>
#include <iceoryx_posh/roudi/port_pool.hpp>

#include "shm_transport/host/chunk_hand.h"

namespace sft::shm {

using iox::mepoo::ChunkHeader;
using iox::mepoo::ChunkManagement;

namespace {

constexpr int looks_max = 10;  // of about 0.1 ms each

std::uint64_t id_of(const iox::popo::UniquePortId& id) {
  return static_cast<iox::popo::UniquePortId::value_type>(id);
}

bool is_odd(std::uint32_t hand) { return hand % 2 != 0; }

}  // namespace

ChunkAuditor::ChunkAuditor(iox::roudi::PortPool& ports, iox::mepoo::MemoryManager& memory)
    : ports_(ports), pools_(pools_of(memory)) {}

void ChunkAuditor::note_ports() {
  std::set<std::uint64_t> there;
  for (const auto* port : ports_.getPublisherPortDataList()) {
    there.insert(id_of(port->m_uniqueId));
    writers_.insert_or_assign(id_of(port->m_uniqueId), port->m_serviceDescription);
  }
  const auto readers = ports_.getSubscriberPortDataList();
  std::erase_if(writers_, [&](const auto& writer) {
    const auto reads = [&](const auto* reader) { return reader->m_serviceDescription == writer.second; };
    return !there.contains(writer.first) && std::ranges::none_of(readers, reads);
  });
}

std::optional<std::size_t> ChunkAuditor::audit() {
  note_ports();
  for (int i = 0; i < looks_max; ++i) {
    if (const auto lost = look()) return free(*lost);
  }
  return std::nullopt;
}

/// Programs go on meanwhile. If one of them has had a chunk in hand, what was seen says nothing.
std::optional<ChunkAuditor::Lost> ChunkAuditor::look() const {
  const Hands before = hands();
  if (std::ranges::any_of(before, is_odd)) return std::nullopt;
  auto lost = find_lost();
  return hands() == before ? lost : std::nullopt;
}

/// Added to rather than read, so that what was read before was read before.
ChunkAuditor::Hands ChunkAuditor::hands() const {
  Hands hands;
  const auto look_at = [&hands](const iox::popo::BasePortData* port) {
    hands.push_back(hand_of(*port).fetch_add(0, std::memory_order_acq_rel));
  };
  std::ranges::for_each(ports_.getPublisherPortDataList(), look_at);
  std::ranges::for_each(ports_.getSubscriberPortDataList(), look_at);
  return hands;
}

std::optional<ChunkAuditor::Lost> ChunkAuditor::find_lost() const {
  Places in_order;
  Lost lost;
  for (const PoolLayout& pool : pools_) {
    in_order.push_back(pool.free_places());
    if (in_order.back().size() != pool.places()) return std::nullopt;
    lost.counted_too_many.push_back(pool.counted_too_many(in_order.back()));
  }
  add_owned(in_order);
  for (const std::vector<bool>& places : in_order) {
    auto& left = lost.places.emplace_back();
    for (std::uint32_t i = 0; i < places.size(); ++i) {
      if (!places[i]) left.push_back(i);
    }
  }
  return lost;
}

/// To the free places: headers that count references, and their chunks, where these are somebody's.
void ChunkAuditor::add_owned(Places& in_order) const {
  for (std::uint32_t i = 0; i < pools_.back().places(); ++i) {
    const auto& header = *reinterpret_cast<const ChunkManagement*>(pools_.back().at(i));
    if (in_order.back()[i] || header.m_referenceCounter.load(std::memory_order_relaxed) == 0) continue;
    for (std::size_t pool = 0; pool + 1 < pools_.size(); ++pool) {
      const auto place = pools_[pool].place_of(header.m_chunkHeader.get());
      if (!place || in_order[pool][*place] || !is_owned(pools_[pool].at(*place))) continue;
      in_order[pool][*place] = in_order.back()[i] = true;
    }
  }
}

/// A chunk that is taken, and has a header.
bool ChunkAuditor::is_owned(const std::byte* chunk) const {
  return writers_.contains(id_of(reinterpret_cast<const ChunkHeader*>(chunk)->originId()));
}

std::size_t ChunkAuditor::free(const Lost& lost) {
  std::size_t chunks = 0;
  for (std::size_t pool = 0; pool < pools_.size(); ++pool) {
    const bool is_of_headers = pool + 1 == pools_.size();
    pools_[pool].correct_count(lost.counted_too_many[pool]);
    for (const std::uint32_t place : lost.places[pool]) {
      if (is_of_headers)
        reinterpret_cast<ChunkManagement*>(pools_[pool].at(place))->m_referenceCounter.store(0);
      pools_[pool].free(place);
    }
    if (!is_of_headers) chunks += lost.places[pool].size();
  }
  return chunks;
}

}  // namespace sft::shm
