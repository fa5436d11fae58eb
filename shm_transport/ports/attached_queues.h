// The queues to which a writer delivers. The name of a queue's port has the id of the reader and its
// requests (queue_wishes.h). Two requests are served here:
//
// A late reader requests the samples that the writer has retained, before all others. The daemon first
// connects the queue of the reader. From then on the writer puts nothing into this queue until it has put
// in the retained samples. Samples that are sent before that are held back from this one queue, and
// counted. They are in the history as well. So a caller that reads the history learns from the count
// whether another sample was sent after it has read. In the queue, the retained samples and the live ones
// follow each other without a gap or a repetition, and no sample is kept for a reader outside of the
// history.
//
// A reliable reader of a writer that waits for its readers requests that the writer waits for room in the
// queue. The writer waits only for those of these readers that it serves in shared memory at present.
//
// Only the readers that the writer serves in shared memory at present get samples. The daemon connects a
// queue before the writer serves its reader. Until the writer does, the reader gets its samples over the
// network. If some of these samples came through the queue as well, a gap between the samples in the queue
// would look like a loss. A reader with conditions gets only the samples that pass its gate (core::Gate): a
// withheld sample takes no place in its queue.
//
// The caller must hold the lock of the port. The daemon holds this lock when it changes the list of queues.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "core/seam/transport.h"
#include "shm_transport/host/iceoryx.h"
#include "shm_transport/host/queue_places.h"

namespace sft::shm {

class Session;

class AttachedQueues {
 public:
  using Port = iox::popo::PublisherPortData::ChunkSenderData_t;
  using Queues = Port::QueueContainer_t;
  using Queue = iox::popo::SubscriberPortData::ChunkQueueData_t;
  struct Listener {
    /// The id of the queue; unlike the queue's memory, an id is never used again.
    iox::cxx::UniqueId queue;
    /// The late reader that waits for the retained samples; 0: no reader waits.
    core::EndpointId waits_as = 0;
    /// The reader if it requests that the writer waits for room; 0: the reader does not request that.
    core::EndpointId awaited = 0;
    core::EndpointId reader = 0;  ///< the reader of the queue; 0: unknown, and `places` has no queue
    QueuePlaces places{};
    WaitingBytes bytes{};                      ///< the bytes that wait in the queue
    bool is_served = false;                    ///< true if the writer serves the reader here
    std::shared_ptr<const core::Gate> gate{};  ///< the gate of the reader, if the reader has conditions

    /// Returns whether the sample that is being sent has to be put into the queue.
    bool wants_sample() const { return is_served && waits_as == 0 && (gate == nullptr || gate->passes()); }
  };
  /// The readers that are served, and the gate of each; null: the reader has no conditions.
  using Served = std::map<core::EndpointId, std::shared_ptr<const core::Gate>>;

  /// Brings the listeners up to date with the queues. Costs little if the queues have not changed since the
  /// last call.
  void look(const Queues& queues, const Session& session);
  /// Returns the listeners that the last look() found, in the order of the queues.
  const std::vector<Listener>& listeners() const { return listeners_; }

  /// Returns whether a late reader waits for retained samples.
  bool has_waiting() const { return waiting_ != 0; }
  /// Returns the listener of this late reader; null if the reader does not wait for retained samples.
  const Listener* waiting(core::EndpointId reader) const;

  /// Notes that this late reader has received the retained samples.
  void begun(core::EndpointId reader);
  /// Sets the late readers that the writer owes no retained samples: they get live samples at once.
  void owe_nothing(std::set<core::EndpointId> readers);

  void serve(Served served);
  /// Returns whether every queue gets every sample.
  bool all_want_all() const { return all_want_all_; }

  /// Sets the readers for which the writer waits, if they request it.
  void wait_for(std::set<core::EndpointId> readers) { awaited_ = std::move(readers); }
  /// Returns a listener that the last look() found, for which the writer waits and whose queue has no room
  /// for a sample of `bytes`; null if there is no such listener.
  const Listener* without_room(std::uint64_t bytes);

  /// Frees a place in each full queue for one more chunk, with a sample of `bytes`. That chunk must be put
  /// into the queues next (queue_places.h, waiting_bytes.h). All listeners must be served here.
  void make_room(std::uint64_t bytes);
  /// Frees a place in the queue of this listener if the queue is full. The listener must be an element of
  /// listeners(). Then puts the chunk into the queue, unless the queue is gone.
  void deliver(Port& port, const Listener& listener, iox::mepoo::SharedChunk chunk, std::uint64_t bytes);
  /// Counts a sample that is held back from the waiting late readers.
  void hold_back() { ++held_back_; }
  std::uint64_t held_back() const { return held_back_; }

 private:
  static Listener listener_at(const Queue& queue, const Session& session);
  void serve(Listener& listener) const;
  bool is_unchanged(const Queues& queues) const;
  void count();

  std::vector<Listener> listeners_;
  std::set<core::EndpointId> owed_nothing_, awaited_;
  Served served_;
  std::size_t waiting_ = 0;  ///< the number of listeners that wait for retained samples
  bool all_want_all_ = true;
  std::uint64_t held_back_ = 0;
};

}  // namespace sft::shm
