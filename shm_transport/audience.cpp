#include "shm_transport/audience.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "shm_transport/session.h"

namespace sft::shm {

void Audience::look(const Queues& queues, const Session& session) {
  if (is_unchanged(queues)) return;
  const std::vector<Listener> before = std::exchange(listeners_, {});
  for (const auto& queue : queues) {
    const auto known = std::ranges::find(before, queue->m_uniqueId, &Listener::queue);
    listeners_.push_back(known != before.end() ? *known
                                               : Listener{queue->m_uniqueId, session.late_reader_at(*queue)});
    if (owed_nothing_.contains(listeners_.back().waits_as)) listeners_.back().waits_as = 0;
  }
  count();
}

bool Audience::is_unchanged(const Queues& queues) const {
  return std::equal(
      queues.begin(), queues.end(), listeners_.begin(), listeners_.end(),
      [](const auto& queue, const Listener& listener) { return queue->m_uniqueId == listener.queue; });
}

const Audience::Listener* Audience::waiting(core::EndpointId reader) const {
  const auto found = std::ranges::find(listeners_, reader, &Listener::waits_as);
  return reader == 0 || found == listeners_.end() ? nullptr : &*found;
}

void Audience::begun(core::EndpointId reader) {
  for (Listener& listener : listeners_) {
    if (listener.waits_as == reader) listener.waits_as = 0;
  }
  count();
}

void Audience::owe_nothing(std::set<core::EndpointId> readers) {
  for (const core::EndpointId reader : readers) begun(reader);
  owed_nothing_ = std::move(readers);
}

void Audience::deliver(Port& port, const Listener& listener, iox::mepoo::SharedChunk chunk) {
  iox::popo::ChunkDistributor<iox::popo::PublisherPortData::ChunkDistributorData_t> distributor(&port);
  std::ignore = distributor.deliverToQueue(listener.queue, 0, std::move(chunk));
}

void Audience::count() {
  waiting_ = static_cast<std::size_t>(
      std::ranges::count_if(listeners_, [](const Listener& listener) { return listener.waits_as != 0; }));
}

}  // namespace sft::shm
