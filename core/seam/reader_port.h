// The receiving end of a transport, for one reader. There are two kinds, as there are two kinds of writers
// (writer_port.h):
//
//   BorrowingReader  Looks at samples in the memory of their writers: the whole sample, in the order of each
//                    writer, woken by a doorbell (core/platform/doorbell.h). What it holds, its writers lack.
//   NetworkReader    Receives bytes, and puts samples together: only the fields that were asked for, perhaps
//                    several variants at one address, woken by a listener or in receive().
//
// Ownership. A port belongs to one reader, and may outlive the transport that opened it: nothing arrives
// then. Samples that were taken outlive the port.
//
// Threads. take() and take_of() are called by any thread, one at a time; what is marked "any thread" by
// several; all else by the node's agent thread, at the same time as these. Listeners are called by threads of
// the transport, and by those in receive().
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
  /// At least one sample can be taken. Called from a thread that receives, which does nothing else meanwhile.
  virtual void arrived() noexcept = 0;

 protected:
  ~ArrivalListener() = default;
};

struct ReaderSpec {
  EndpointId id = 0;
  const TypeSupport* type = nullptr;  ///< outlives the port
  std::uint32_t depth = 1;            ///< samples kept until taken, per writer; the oldest goes first
  /// Outlives the port. A NetworkReader calls it.
  ArrivalListener* listener = nullptr;
  /// The doorbell that the writers of a BorrowingReader ring.
  DoorbellAddress doorbell;
  /// Handles of one writer that may be out; take() of a BorrowingReader gives no more of that writer then.
  std::uint32_t max_held = SubscriberOptions::max_held_most;
  /// True if all that the listener does is to ring `doorbell`, for threads in NetworkReader::receive(). Each
  /// of these threads may ring it for the others.
  bool only_waited_for = false;
  /// The time for which the thread that calls the listener looks for more, and keeps a core busy with it,
  /// before it sleeps.
  std::chrono::nanoseconds spin{0};
  /// The bytes of samples kept until taken, per writer. The oldest go first, but the newest one always stays;
  /// 0: no limit. Shared memory may round it down to a power of two.
  std::uint64_t depth_bytes = 0;
};

/// A thread that waits for a sample, until its reader's doorbell is rung.
struct Waiting {
  Doorbell& bell;
  std::uint32_t seen = 0;  ///< of its rings
  std::chrono::steady_clock::time_point deadline;
  std::chrono::steady_clock::time_point spin_until;  ///< keeps the core busy so long
};

/// The progress of a late reader with the samples that come for it alone.
enum class HistoryProgress : std::uint8_t {
  awaited,  ///< nothing has come yet
  coming,
  came,  ///< nothing of it is under way any more
};

class ReaderPort {
 public:
  virtual ~ReaderPort() = default;

  /// The oldest sample not yet taken, validated so far that every getter is safe; empty if there is none.
  virtual SampleHandle take() noexcept = 0;

  /// Begins to accept a writer's samples. May ask a daemon, as SharedMemory::open_writer() does.
  virtual Result<void> connect(const Source& source) = 0;
  /// True if samples that the writer sends from now on will arrive.
  virtual bool connected(EndpointId writer) const noexcept = 0;
  /// Accepts no more of them; what has arrived can still be taken.
  virtual void disconnect(EndpointId writer) noexcept = 0;
  /// The progress of a writer that was connected to with `history_first`.
  virtual HistoryProgress history(EndpointId writer) const noexcept = 0;
  /// Differs from what it was whenever a sample of that writer has arrived meanwhile, taken or not.
  virtual std::uint64_t arrivals(EndpointId writer) noexcept = 0;

  struct Counters {
    /// Samples that arrived whole and were thrown away: pushed out of a full queue, or malformed.
    std::uint64_t discarded = 0;
    /// The part of `discarded` that no gap in the sequences of taken samples shows: samples before the first
    /// one of a writer, or behind the last one of a writer that was disconnected.
    std::uint64_t lost_unnoticed = 0;
  };
  /// Any thread.
  virtual Counters counters() const noexcept = 0;
};

/// A reader of samples that lie in memory of their writers.
class BorrowingReader : public ReaderPort {
 public:
  /// Does what take() does, for that writer only: samples of one writer may have to go before those of
  /// others.
  virtual SampleHandle take_of(EndpointId writer) noexcept = 0;
  /// True if a sample waits, also one that take() does not give because as many are held as may be. Any
  /// thread.
  virtual bool some_wait() const noexcept = 0;
  /// Wakes writers that wait for room that take() has made since this was called last. After take(), without
  /// a lock: it may make a system call. Any thread.
  virtual void notify_room() noexcept = 0;
  /// Times that as many samples of a writer were held as may be, and the next one could not be taken. Any
  /// thread.
  virtual std::uint64_t held_too_many() const noexcept = 0;
};

/// A reader of samples that come as bytes.
class NetworkReader : public ReaderPort {
 public:
  /// Waits where samples come in, and does the transport's receiving there. This spares samples the way from
  /// one thread to another. Listeners of this and other readers are called meanwhile. Spurious returns are
  /// possible. Returns false at once if this is not possible: the transport has a thread of its own for it,
  /// and the bell will be rung. Any thread.
  virtual bool receive(const Waiting& waiting) noexcept = 0;
  /// Tells that the reader has samples by another transport from now on, too, which those of this transport
  /// must not fall behind: the transport's own thread receives from now on. So only this transport rings the
  /// bell of a thread that is in receive().
  virtual void share_reader() = 0;

  /// Tells that a connected writer has announced something else than before, or that its node answers, or
  /// does not. `history_first` does not change.
  virtual void announced(const Source& source) = 0;
  /// Sets which samples are for this reader: what it requests now comes last, and before it what it requested
  /// earlier, while such samples may be under way. Variants for several readers may come to one address.
  virtual void accept(std::vector<Accepted> accepted) = 0;
};

}  // namespace sft::core
