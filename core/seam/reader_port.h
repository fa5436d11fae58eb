// The receiving end of a transport, for one reader. There are two kinds, as there are two kinds of writers
// (writer_port.h):
//
//   BorrowingReader  Reads samples in the memory of their writers: whole samples, in the order of each
//                    writer. It is woken by a doorbell (core/platform/doorbell.h). Writers cannot reuse the
//                    memory of samples that it holds.
//   NetworkReader    Receives bytes, and puts samples together: only the fields that were asked for, perhaps
//                    several variants at one address. It is woken by a listener or in receive().
//
// Ownership. A port belongs to one reader, and may outlive the transport that opened it: nothing arrives
// then. Samples that were taken outlive the port.
//
// Threads. take() and take_of() may be called by any thread, one at a time. Functions marked "any thread" may
// be called by several threads at once. The node's agent thread calls all others, at the same time as these.
// Listeners are called by threads of the transport, and by threads in receive().
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
  /// Called when at least one sample can be taken, by a thread that receives, which does nothing else
  /// meanwhile.
  virtual void arrived() noexcept = 0;

 protected:
  ~ArrivalListener() = default;
};

struct ReaderSpec {
  EndpointId id = 0;
  const TypeSupport* type = nullptr;  ///< outlives the port
  std::uint32_t depth = 1;            ///< samples kept until taken, per writer; the oldest are dropped first
  /// Called by a NetworkReader. It outlives the port.
  ArrivalListener* listener = nullptr;
  /// The doorbell that the writers of a BorrowingReader ring.
  DoorbellAddress doorbell;
  /// The number of samples of one writer that may be held at a time. While that many are held, take() of a
  /// BorrowingReader returns no more of that writer.
  std::uint32_t max_held = SubscriberOptions::max_held_most;
  /// True if the listener only rings `doorbell` for threads in NetworkReader::receive(). Then each of these
  /// threads may ring it for the others instead.
  bool only_waited_for = false;
  /// The time for which the thread that calls the listener polls for more samples, and keeps a core busy,
  /// before it sleeps.
  std::chrono::nanoseconds spin{0};
  /// The bytes of samples kept until taken, per writer. The oldest samples are dropped first, but the newest
  /// one always stays; 0: no limit. Shared memory may round the number down to a power of two.
  std::uint64_t depth_bytes = 0;
};

/// A thread that waits for a sample, until its reader's doorbell is rung.
struct Waiting {
  Doorbell& bell;
  std::uint32_t seen = 0;  ///< the number of rings of `bell` that it has seen
  std::chrono::steady_clock::time_point deadline;
  std::chrono::steady_clock::time_point spin_until;  ///< the time until which it polls before it sleeps
};

/// The progress of a late reader with the retained samples, which are sent to it alone.
enum class HistoryProgress : std::uint8_t {
  awaited,  ///< no retained sample has come yet
  coming,
  came,  ///< no retained sample is under way any more
};

class ReaderPort {
 public:
  virtual ~ReaderPort() = default;

  /// Returns the oldest sample not yet taken, or an empty handle if there is none. The sample is validated so
  /// far that every getter is safe.
  virtual SampleHandle take() noexcept = 0;

  /// Begins to accept a writer's samples. May ask a daemon, as SharedMemory::open_writer() does.
  virtual Result<void> connect(const Source& source) = 0;
  /// Returns true if samples that the writer sends from now on will arrive.
  virtual bool connected(EndpointId writer) const noexcept = 0;
  /// Accepts no more samples of the writer; those that have arrived can still be taken.
  virtual void disconnect(EndpointId writer) noexcept = 0;
  /// Returns the progress of the retained samples of a writer that was connected with `history_first`.
  virtual HistoryProgress history(EndpointId writer) const noexcept = 0;
  /// Returns a number that changes whenever a sample of that writer arrives, taken or not.
  virtual std::uint64_t arrivals(EndpointId writer) noexcept = 0;

  struct Counters {
    /// Samples that arrived completely and were discarded: pushed out of a full queue, or malformed.
    std::uint64_t discarded = 0;
    /// The part of `discarded` that no gap in the sequences of taken samples shows: samples before the first
    /// one that was taken of a writer, or after the last one of a writer that was disconnected.
    std::uint64_t lost_unnoticed = 0;
  };
  /// May be called by any thread.
  virtual Counters counters() const noexcept = 0;
};

/// A reader of samples that lie in memory of their writers.
class BorrowingReader : public ReaderPort {
 public:
  /// Does what take() does, but for that writer only: samples of one writer may have to be delivered before
  /// those of others.
  virtual SampleHandle take_of(EndpointId writer) noexcept = 0;
  /// Returns true if a sample waits, even one that take() does not return because max_held samples are held.
  /// May be called by any thread.
  virtual bool some_wait() const noexcept = 0;
  /// Wakes writers that wait for room in the queue, if take() has made room since the last call. To be called
  /// after take(), while no lock is held, since it may make a system call. Any thread.
  virtual void notify_room() noexcept = 0;
  /// Returns how often the next sample could not be taken because max_held samples of its writer were held.
  /// May be called by any thread.
  virtual std::uint64_t held_too_many() const noexcept = 0;
};

/// A reader of samples that come as bytes.
class NetworkReader : public ReaderPort {
 public:
  /// Waits for samples, and receives for the whole transport on the calling thread. So samples need not be
  /// passed from one thread to another. Listeners of this and other readers are called meanwhile. Spurious
  /// returns are possible. Returns false at once if this is not possible, because a thread of the transport
  /// receives; then the bell will be rung. Any thread.
  virtual bool receive(const Waiting& waiting) noexcept = 0;
  /// Called when the reader gets samples by another transport, too. From then on the transport's own thread
  /// receives, so that samples of this transport do not lag behind the others. Hence only this transport
  /// rings the bell of a thread that is in receive().
  virtual void share_reader() = 0;

  /// Called when a connected writer has changed its announcement, or when its node begins or ceases to
  /// answer. `history_first` does not change.
  virtual void announced(const Source& source) = 0;
  /// Sets which samples are for this reader: those of its present request, which comes last, and those of
  /// earlier ones, while such samples may be under way. Variants for several readers may come to one address.
  virtual void accept(std::vector<Accepted> accepted) = 0;
};

}  // namespace sft::core
