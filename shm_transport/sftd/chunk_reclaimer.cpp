#include "shm_transport/sftd/chunk_reclaimer.h"

#include <algorithm>

#include <iceoryx_posh/roudi/port_pool.hpp>

namespace sft::shm {

using iox::mepoo::ShmSafeUnmanagedChunk;

namespace {

/// Leaves only the reference that `chunk` itself counts for. Returns whether there were others.
bool drop_other_references(const ShmSafeUnmanagedChunk& chunk) {
  bool dropped = false;
  for (ShmSafeUnmanagedChunk lost = chunk; !lost.isNotLogicalNullptrAndHasNoOtherOwners(); lost = chunk) {
    lost.releaseToSharedChunk();  // a copy does not count, so this takes away one that somebody else counted
    dropped = true;
  }
  return dropped;
}

}  // namespace

void ChunkReclaimer::note_deliveries(const iox::RuntimeName_t& dead) {
  for (auto* port : ports_.getPublisherPortDataList()) {
    if (port->m_runtimeName != dead) continue;
    auto& deliveries = port->m_chunkSenderData.m_history;
    for (ShmSafeUnmanagedChunk& name : deliveries) {
      suspects_.push_back({ShmSafeUnmanagedChunk(name.cloneToSharedChunk()), port->m_serviceDescription});
    }
    deliveries.clear();  // the names count for nothing, which iceoryx does not know
  }
}

std::size_t ChunkReclaimer::reclaim() {
  std::size_t reclaimed = 0;
  for (auto suspect = suspects_.begin(); suspect != suspects_.end();) {
    if (has_readers(suspect->service)) {
      ++suspect;
      continue;
    }
    if (drop_other_references(suspect->chunk)) ++reclaimed;
    suspect->chunk.releaseToSharedChunk();
    suspect = suspects_.erase(suspect);
  }
  return reclaimed;
}

bool ChunkReclaimer::has_readers(const iox::capro::ServiceDescription& service) const {
  const auto readers = ports_.getSubscriberPortDataList();
  return std::any_of(readers.begin(), readers.end(),
                     [&service](const auto* reader) { return reader->m_serviceDescription == service; });
}

}  // namespace sft::shm
