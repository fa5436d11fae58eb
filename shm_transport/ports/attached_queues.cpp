#include "shm_transport/ports/attached_queues.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "shm_transport/host/session.h"

namespace sft::shm {

void AttachedQueues::look(const Queues& queues, const Session& session) {
  if (is_unchanged(queues)) return;
  const std::vector<Listener> before = std::exchange(listeners_, {});
  for (const auto& queue : queues) {
    const auto known = std::ranges::find(before, queue->m_uniqueId, &Listener::queue);
    listeners_.push_back(known != before.end() ? *known : listener_at(*queue, session));
    if (owed_nothing_.contains(listeners_.back().waits_as)) listeners_.back().waits_as = 0;
    serve(listeners_.back());
  }
  count();
}

AttachedQueues::Listener AttachedQueues::listener_at(const Queue& queue, const Session& session) {
  auto* const port = const_cast<iox::popo::SubscriberPortData*>(session.port_of(queue));
  if (port == nullptr) return {queue.m_uniqueId};
  const QueueWishes wishes = parse_wishes({port->m_nodeName.c_str(), port->m_nodeName.size()});
  return {queue.m_uniqueId, wishes.late ? wishes.reader : 0, wishes.awaited ? wishes.reader : 0,
          wishes.reader,    {*port, wishes.deepest},         {wishes.bytes_max, QueuePlaces::depth_max}};
}

void AttachedQueues::serve(Listener& listener) const {
  const auto found = served_.find(listener.reader);
  listener.is_served = found != served_.end();
  listener.gate = listener.is_served ? found->second : nullptr;
}

void AttachedQueues::serve(Served served) {
  served_ = std::move(served);
  for (Listener& listener : listeners_) serve(listener);
  count();
}

const AttachedQueues::Listener* AttachedQueues::without_room(std::uint64_t bytes) {
  if (awaited_.empty()) return nullptr;
  const auto found = std::ranges::find_if(listeners_, [&](Listener& listener) {
    return listener.awaited != 0 && listener.wants_sample() && awaited_.contains(listener.awaited) &&
           !listener.places.has_room(listener.bytes.beside(bytes));
  });
  return found == listeners_.end() ? nullptr : &*found;
}

void AttachedQueues::make_room(std::uint64_t bytes) {
  for (Listener& listener : listeners_) {
    listener.places.make_room(listener.bytes.beside(bytes));
    listener.bytes.pushed(bytes);
  }
}

bool AttachedQueues::is_unchanged(const Queues& queues) const {
  return std::equal(
      queues.begin(), queues.end(), listeners_.begin(), listeners_.end(),
      [](const auto& queue, const Listener& listener) { return queue->m_uniqueId == listener.queue; });
}

const AttachedQueues::Listener* AttachedQueues::waiting(core::EndpointId reader) const {
  const auto found = std::ranges::find(listeners_, reader, &Listener::waits_as);
  return reader == 0 || found == listeners_.end() ? nullptr : &*found;
}

void AttachedQueues::begun(core::EndpointId reader) {
  for (Listener& listener : listeners_) {
    if (listener.waits_as == reader) listener.waits_as = 0;
  }
  count();
}

void AttachedQueues::owe_nothing(std::set<core::EndpointId> readers) {
  for (const core::EndpointId reader : readers) begun(reader);
  owed_nothing_ = std::move(readers);
}

void AttachedQueues::deliver(Port& port, const Listener& listener, iox::mepoo::SharedChunk chunk,
                             std::uint64_t bytes) {
  // iceoryx searches for the queue at this index first.
  const auto index = static_cast<std::uint32_t>(&listener - listeners_.data());
  listeners_[index].places.make_room(listener.bytes.beside(bytes));
  listeners_[index].bytes.pushed(bytes);
  iox::popo::ChunkDistributor<iox::popo::PublisherPortData::ChunkDistributorData_t> distributor(&port);
  std::ignore = distributor.deliverToQueue(listener.queue, index, std::move(chunk));
}

void AttachedQueues::count() {
  waiting_ = static_cast<std::size_t>(
      std::ranges::count_if(listeners_, [](const Listener& listener) { return listener.waits_as != 0; }));
  all_want_all_ = waiting_ == 0 && std::ranges::all_of(listeners_, [](const Listener& listener) {
                    return listener.is_served && listener.gate == nullptr;
                  });
}

}  // namespace sft::shm
