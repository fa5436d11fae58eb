// The counts of a publisher's samples that were sent, withheld, dropped or lost, for each of its readers.
//
// Readers that get the same samples form a group, and the sender counts in the tally of the group. This
// takes three additions for a sample, whatever the number of readers. A page is a table that assigns
// tallies to readers while certain routes are in force. New routes have new tallies and a new page; the
// former tallies are not used any more. The book keeps the sum of each reader's counts over all pages. The
// publisher's thread replaces the page ("turns" it) between two samples, when it begins to count in the new
// tallies. So each sample counts exactly once.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "core/seam/gate.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

namespace sft::core {

/// The counts of one reader, or the sum for several readers. Bytes are counted for bodies, without headers.
struct Delivered {
  std::uint64_t sent = 0;
  std::uint64_t withheld = 0;
  std::uint64_t dropped = 0;
  std::uint64_t retained = 0;
  std::uint64_t diverted = 0;     ///< the part of `sent` that was sent by a fallback route
  std::uint64_t bytes = 0;        ///< the size of the samples sent, in bytes
  std::uint64_t bytes_saved = 0;  ///< bytes of the fields that were left out of the samples sent
  friend bool operator==(const Delivered&, const Delivered&) = default;
};

/// The counts of one group of readers. Any thread may use it.
class DeliveryTally {
 public:
  /// Counts samples that were sent with `bytes` bytes in all. `whole_bytes` is the size of the same samples
  /// with all their fields.
  void sent(std::uint64_t bytes, std::uint64_t whole_bytes, std::uint64_t samples = 1) noexcept {
    sent_.fetch_add(samples, std::memory_order_relaxed);
    bytes_.fetch_add(bytes, std::memory_order_relaxed);
    whole_bytes_.fetch_add(whole_bytes, std::memory_order_relaxed);
  }
  void dropped() noexcept { dropped_.fetch_add(1, std::memory_order_relaxed); }

 private:
  friend class DeliveryMeter;
  std::atomic<std::uint64_t> sent_{0}, dropped_{0}, bytes_{0}, whole_bytes_{0};
};

/// The losses of the readers of one queue: samples that counted as sent, but never left the queue. Any
/// thread may use it.
class LossTally {
 public:
  void lost(std::uint64_t bytes, std::uint64_t whole_bytes, std::uint64_t samples = 1) noexcept {
    lost_.fetch_add(samples, std::memory_order_relaxed);
    bytes_.fetch_add(bytes, std::memory_order_relaxed);
    whole_bytes_.fetch_add(whole_bytes, std::memory_order_relaxed);
  }

 private:
  friend class DeliveryMeter;
  std::atomic<std::uint64_t> lost_{0}, bytes_{0}, whole_bytes_{0};
};

/// The tallies in which samples for one reader are counted while one page is in force. Each pointer may be
/// null.
class DeliveryMeter {
 public:
  /// The values of the tallies at a point in time. Only differences of two readings are meaningful.
  struct Reading {
    std::uint64_t sent = 0, dropped = 0, bytes = 0, whole_bytes = 0;
    std::uint64_t lost = 0, lost_bytes = 0, lost_whole_bytes = 0;
    std::uint64_t withheld = 0;
    std::uint64_t diverted = 0;
    Reading& operator+=(const Reading& other) noexcept;
    Reading& operator-=(const Reading& other) noexcept;
    Delivered delivered() const noexcept;
  };
  Reading read() const noexcept;

  std::shared_ptr<const DeliveryTally> tally{};
  std::shared_ptr<const LossTally> losses{};
  std::shared_ptr<const Gate> gate{};
  bool diverted = false;  ///< true: the tally counts for a fallback route
};

class DeliveryBook {
 public:
  /// The component that counts: the publisher itself, or its network port. Each component replaces its own
  /// pages.
  enum class Origin : std::uint8_t { publisher, network };
  /// The assignment of tallies to readers: the ids of the readers, each with its meter.
  using Page = std::vector<std::pair<std::uint64_t, DeliveryMeter>>;

  // The functions for the agent's thread.

  /// Opens accounts for the readers of the page. Must be called with each page before turn_to().
  void enter(const Page& page);
  /// Adds to the count of retained samples that were sent to a reader at first.
  void retained(std::uint64_t reader, std::uint64_t samples);
  /// Removes the accounts of all readers except `readers`. A removed reader must not be entered again. From
  /// then on its counts are contained only in total().
  void keep(const std::set<std::uint64_t>& readers);

  /// What may happen to the tallies of the previous page. `to_come`: they may still increase until the next
  /// call of turn_to(), and the new page must not contain any of them.
  enum class LateCounts : std::uint8_t { none, to_come };

  /// Puts `page` into use for `origin`. Called by the publisher's thread. Allocates nothing.
  void turn_to(Origin origin, const Page& page, LateCounts late = LateCounts::none) noexcept;

  // The functions for any thread.

  Delivered of(std::uint64_t reader) const;
  /// Returns the counts of all readers together, including departed readers.
  Delivered total() const;

 private:
  struct Counts {  ///< The counts of one origin for one reader. The total is `before`, plus the growth of
                   ///< `meter`, plus the growth of `late`.
    DeliveryMeter::Reading before{};
    DeliveryMeter::Reading at_first{};  ///< the reading of `meter` when the present page was put into use
    DeliveryMeter meter{};
    DeliveryMeter::Reading at_last{};  ///< the reading of `late` that is already contained in `before`
    DeliveryMeter late{};              ///< the meter of the previous page, if its tallies may still grow
    void close(LateCounts late_counts) noexcept;
    DeliveryMeter::Reading sum() const noexcept;
  };
  struct Account {
    Counts columns[2];
    std::uint64_t retained = 0;
    bool gone = false;
    bool open() const noexcept;
    Delivered delivered() const noexcept;
  };
  void forget_the_gone() SFT_REQUIRES(mutex_);

  mutable Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::queues) SFT_ACQUIRED_BEFORE(lock_order::facts);
  std::map<std::uint64_t, Account> accounts_ SFT_GUARDED_BY(mutex_);
  Delivered gone_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
