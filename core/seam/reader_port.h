// The receiving end of a transport, for one reader. There are two kinds, as there are two kinds of writers
// (writer_port.h):
//
//   BorrowingReader  Reads whole samples in the memory of their writers, in the order of each writer. The
//                    reader is woken by a doorbell (core/platform/doorbell.h). Writers cannot reuse the
//                    memory of samples that the reader holds.
//   NetworkReader    Receives bytes, and assembles samples from them: only the requested fields, perhaps
//                    several variants at one address. The reader is woken by a listener or in receive().
//
// Ownership. A port belongs to one reader, and may outlive the transport that opened it. After the end of
// the transport no sample arrives. Samples that were taken may outlive the port.
//
// Threads. take() and take_of() may be called by any thread, one at a time. Functions marked "any thread"
// may be called by several threads at once. The node's agent thread calls all other functions, possibly at
// the same time. Listeners are called by threads of the transport, and by threads in receive().
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/seam/address.h"
#include "core/seam/route.h"
#include "core/seam/sample_buffer.h"
#include "sft/options.h"
#include "sft/result.h"
#include "sft/type_support.h"

namespace sft::core {

struct Doorbell;

class ArrivalListener {
 public:
  /// Called by a receiving thread when at least one sample can be taken. The thread receives nothing until
  /// the call returns.
  virtual void arrived() noexcept = 0;

 protected:
  ~ArrivalListener() = default;
};

struct ReaderSpec {
  EndpointId id = 0;
  const TypeSupport* type = nullptr;  ///< must outlive the port
  /// The maximum number of samples of one writer that are kept until they are taken. Further samples
  /// replace the oldest ones.
  std::uint32_t depth = 1;
  /// The listener of a NetworkReader. It must outlive the port.
  ArrivalListener* listener = nullptr;
  /// The doorbell that the writers of a BorrowingReader ring.
  DoorbellAddress doorbell;
  /// The maximum number of samples of one writer that the program may hold at a time. While this number is
  /// held, take() of a BorrowingReader returns no more samples of that writer.
  std::uint32_t max_held = SubscriberOptions::max_held_most;
  /// True: the listener only rings `doorbell` for threads in NetworkReader::receive(). Then such a thread
  /// may ring the doorbell for the other threads instead of the listener.
  bool only_waited_for = false;
  /// The time for which the thread that calls the listener polls for more samples before it sleeps. Polling
  /// keeps a core busy.
  std::chrono::nanoseconds spin{0};
  /// The maximum size in bytes of the samples of one writer that are kept until they are taken; 0: no
  /// limit. If more arrive, the oldest samples are dropped, but the newest sample is always kept. Shared
  /// memory may round the number down to a power of two.
  std::uint64_t depth_bytes = 0;
};

/// A thread that waits for a sample until the doorbell of its reader is rung.
struct Waiting {
  Doorbell& bell;
  std::uint32_t seen = 0;  ///< the number of rings of `bell` that the thread has seen
  std::chrono::steady_clock::time_point deadline;
  /// The time until which the thread polls before it sleeps.
  std::chrono::steady_clock::time_point spin_until;
};

/// The progress of a late reader in receiving the retained samples, which are sent to this reader alone.
enum class HistoryProgress : std::uint8_t {
  awaited,  ///< no retained sample has arrived yet
  coming,
  came,  ///< all retained samples have arrived, or none of them can arrive any more
};

class ReaderPort {
 public:
  virtual ~ReaderPort() = default;

  /// Returns the oldest sample not yet taken, or an empty handle if there is none. The sample is validated,
  /// so that every getter is safe.
  virtual SampleHandle take() noexcept = 0;

  /// Begins to accept a writer's samples. May send a request to a daemon, as SharedMemory::open_writer()
  /// does.
  virtual Result<void> connect(const Source& source) = 0;
  /// Returns true if samples that the writer sends from now on will arrive.
  virtual bool connected(EndpointId writer) const noexcept = 0;
  /// Stops accepting samples of the writer; samples that have arrived before can still be taken.
  virtual void disconnect(EndpointId writer) noexcept = 0;
  /// Returns the progress of the retained samples of a writer that was connected with `history_first`.
  virtual HistoryProgress history(EndpointId writer) const noexcept = 0;
  /// Returns a number that changes whenever a sample of that writer arrives, taken or not.
  virtual std::uint64_t arrivals(EndpointId writer) noexcept = 0;

  struct Counters {
    /// Samples that arrived completely and were discarded, because they were malformed or the queue was
    /// full.
    std::uint64_t discarded = 0;
    /// The part of `discarded` that causes no gap between the sequences of taken samples: samples before
    /// the first sample that was taken of a writer, or after the last sample that was taken of a
    /// disconnected writer.
    std::uint64_t lost_unnoticed = 0;
  };
  /// Returns the counts since the port was opened. Any thread may call this.
  virtual Counters counters() const noexcept = 0;
};

/// A reader of samples that stay in the memory of their writers.
class BorrowingReader : public ReaderPort {
 public:
  /// Does the same as take(), but for one writer only, since samples of one writer may have to be delivered
  /// before those of other writers.
  virtual SampleHandle take_of(EndpointId writer) noexcept = 0;
  /// Returns true if a sample has not been taken yet, even if take() does not return this sample because
  /// max_held samples are held. Any thread may call this.
  virtual bool some_wait() const noexcept = 0;
  /// Wakes writers that wait for a free slot in the queue, if take() has freed one since the last call.
  /// Must be called after take(). No lock must be held during the call, since it may make a system call.
  /// Any thread may call this.
  virtual void notify_room() noexcept = 0;
  /// Returns how often the next sample could not be taken because max_held samples of its writer were held.
  /// Any thread may call this.
  virtual std::uint64_t held_too_many() const noexcept = 0;
};

/// A reader of samples that arrive as bytes over a network.
class NetworkReader : public ReaderPort {
 public:
  /// Waits for samples, and receives for the whole transport on the calling thread, so that samples need
  /// not be passed from one thread to another. Listeners of this reader and of other readers are called
  /// meanwhile. Spurious returns are possible. Returns false at once if a thread of the transport is
  /// receiving; that thread then rings the doorbell. Any thread may call this.
  virtual bool receive(const Waiting& waiting) noexcept = 0;
  /// Called when the reader begins to get samples by another transport, too. From then on the transport's
  /// own thread receives, so that samples of this transport are not delayed against samples of the other
  /// transport. Before that, only this transport rings the doorbell of a thread that is in receive().
  virtual void share_reader() = 0;

  /// Called when a connected writer has changed its announcement, or when its node begins or ceases to
  /// answer. `history_first` must not change.
  virtual void announced(const Source& source) = 0;
  /// Sets which samples are for this reader. The last element of `accepted` is the present request of the
  /// reader. The elements before it are earlier requests for which samples may still be under way. The
  /// choice is necessary because variants for several readers may arrive at one address.
  virtual void accept(std::vector<Accepted> accepted) = 0;
};

}  // namespace sft::core
