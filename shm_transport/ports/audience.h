// Which queues a writer delivers to, which of them wait for what it has retained before it, and for which the
// writer waits until there is room.
//
// A reader that wants that says so in the name of its port. From the moment that the daemon connects its
// queue nothing is put into it, until the writer has put in what it retains; samples sent meanwhile are held
// back from this one queue. They are in the history too, and whoever looks there afterwards can tell by the
// number of samples held back whether another one was sent since. So in the queue what was retained and what
// is live follow each other without gap or repetition, and nothing is ever kept for a reader beside the
// history.
//
// A reliable reader of a writer that waits for its readers says that, too, in the name of its port. The
// writer waits for those of them that it serves in shared memory at present.
//
// Used with the port's lock held, in which the daemon, too, changes its list of queues.
#pragma once

#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "core/seam/transport.h"
#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

class Session;

class Audience {
 public:
  using Port = iox::popo::PublisherPortData::ChunkSenderData_t;
  using Queues = Port::QueueContainer_t;
  using Queue = iox::popo::SubscriberPortData::ChunkQueueData_t;
  struct Listener {
    iox::cxx::UniqueId queue;       ///< never used again, unlike its memory
    core::EndpointId waits_as = 0;  ///< the reader that waits there; 0: none does
    core::EndpointId awaited = 0;   ///< the reader that is waited for, as it wishes; 0: none
    const iox::popo::SubscriberPortData* port = nullptr;  ///< of that
  };

  /// As the queues are now. Cheap while they are those of before.
  void look(const Queues& queues, const Session& session);
  /// In the order of the queues, when they were last looked at.
  const std::vector<Listener>& listeners() const { return listeners_; }

  bool somebody_waits() const { return waiting_ != 0; }
  /// The queue in which that reader waits; null if it does not.
  const Listener* waiting(core::EndpointId reader) const;

  void begun(core::EndpointId reader);
  /// These are owed nothing, now and later.
  void owe_nothing(std::set<core::EndpointId> readers);

  /// These, of those that wish it, are waited for from now on.
  void wait_for(std::set<core::EndpointId> readers) { awaited_ = std::move(readers); }
  /// A reader to be waited for whose queue is full, as it was when the queues were last looked at; null if
  /// there is none.
  const Listener* without_room() const;
  static bool has_room(const Listener& listener);

  /// Puts it into that one queue, unless that is gone.
  static void deliver(Port& port, const Listener& listener, iox::mepoo::SharedChunk chunk);
  void hold_back() { ++held_back_; }
  std::uint64_t held_back() const { return held_back_; }

 private:
  static Listener listener_at(const Queue& queue, const Session& session);
  bool is_unchanged(const Queues& queues) const;
  void count();

  std::vector<Listener> listeners_;
  std::set<core::EndpointId> owed_nothing_, awaited_;
  std::size_t waiting_ = 0;
  std::uint64_t held_back_ = 0;
};

}  // namespace sft::shm
