#include "shm_transport/sftd/usage_monitor.h"

#include <algorithm>

#include <iceoryx_posh/roudi/port_pool.hpp>

#include "shm_transport/host/host_file.h"

namespace sft::shm {

namespace {

using Subscribers = iox::cxx::vector<iox::popo::SubscriberPortData*, iox::MAX_SUBSCRIBERS>;

/// Returns whether the port belongs to a program, and not to iceoryx itself.
bool is_ours(const iox::popo::BasePortData& port) { return is_runtime_name(port.m_runtimeName.c_str()); }

/// Returns whether the port is never subscribed, and only lists the chunks that a writer holds.
bool is_keeper(const iox::popo::SubscriberPortData& port) { return !port.m_options.subscribeOnCreate; }

const iox::popo::SubscriberPortData* keeper_of(const iox::popo::PublisherPortData& publisher,
                                               const Subscribers& subscribers) {
  const auto found = std::ranges::find_if(subscribers, [&](const auto* port) {
    return is_keeper(*port) && port->m_serviceDescription == publisher.m_serviceDescription &&
           port->m_runtimeName == publisher.m_runtimeName;
  });
  return found == subscribers.end() ? nullptr : *found;
}

std::string publisher_id(const iox::popo::BasePortData& port) {
  return port.m_serviceDescription.getEventIDString().c_str();
}

}  // namespace

Usage UsageMonitor::look() {
  Usage usage;
  look_at_pools(usage);
  Peaks peaks;
  const Subscribers subscribers = ports_.getSubscriberPortDataList();
  for (const auto* port : ports_.getPublisherPortDataList()) {
    if (!is_ours(*port)) continue;
    Holding held = holdings_.of(*port, keeper_of(*port, subscribers));
    note_peak(*port, held, peaks);
    const auto readers = static_cast<std::uint32_t>(port->m_chunkSenderData.m_queues.size());
    usage.publishers.push_back({port->m_runtimeName.c_str(), publisher_id(*port), readers, held});
  }
  // Not a pointer to const, because iceoryx's size() of a queue is not const.
  for (auto* port : subscribers) {
    if (!is_ours(*port) || is_keeper(*port)) continue;
    Holding held = holdings_.of(*port);
    note_peak(*port, held, peaks);
    const auto waiting = static_cast<std::uint32_t>(port->m_chunkReceiverData.m_queue.size());
    usage.subscribers.push_back({port->m_runtimeName.c_str(), publisher_id(*port), waiting, held});
  }
  peaks_.swap(peaks);
  return usage;
}

void UsageMonitor::look_at_pools(Usage& usage) const {
  for (std::uint32_t i = 0; i < pools_.getNumberOfMemPools(); ++i) {
    const auto pool = pools_.getMemPoolInfo(i);
    usage.pools.push_back({pool.m_chunkSize - sizeof(iox::mepoo::ChunkHeader), pool.m_numChunks,
                           pool.m_usedChunks, pool.m_numChunks - pool.m_minFreeChunks});
  }
}

void UsageMonitor::note_peak(const iox::popo::BasePortData& port, Holding& held, Peaks& peaks) const {
  const auto id = static_cast<iox::popo::UniquePortId::value_type>(port.m_uniqueId);
  const auto before = peaks_.find(id);
  held.peak = std::max(held.chunks, before == peaks_.end() ? 0 : before->second);
  peaks.emplace(id, held.peak);
}

}  // namespace sft::shm
