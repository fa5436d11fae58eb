// The counts of a publisher's samples that were sent, withheld, dropped or lost, for each of its readers.
//
// Counts are kept for groups of readers that get the same samples. The sender adds to the tally of a group:
// three additions for a sample, whatever the number of readers. A page says which tallies belong to which
// reader. New routes bring new tallies and pages; the old tallies end with the old routes. The book carries
// each reader's counts from page to page. The publisher's thread turns the page between two samples, at the
// time when it begins to count by the new tallies. So each sample counts exactly once.
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

/// The counts of one reader, or of several together. Bytes are those of bodies, without headers.
struct Delivered {
  std::uint64_t sent = 0;
  std::uint64_t withheld = 0;
  std::uint64_t dropped = 0;
  std::uint64_t retained = 0;
  std::uint64_t diverted = 0;     ///< the part of `sent` that went by a fallback route
  std::uint64_t bytes = 0;        ///< bytes that were sent
  std::uint64_t bytes_saved = 0;  ///< bytes of the fields that were left out of the samples sent
  friend bool operator==(const Delivered&, const Delivered&) = default;
};

/// The counts of one group of readers. Any thread.
class DeliveryTally {
 public:
  /// Counts samples of which `bytes` were sent. `whole_bytes` is the size of the samples with all their
  /// fields.
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

/// The losses of the readers of one queue: samples that counted as sent and never left the queue. Any thread.
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

/// The tallies that count for a reader while one page is open. Each of the pointers may be null.
class DeliveryMeter {
 public:
  /// The values of the tallies at one time. Only differences of two readings are meaningful.
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
  /// The component that counts: the publisher itself, or its port to the network. Each component turns its
  /// own pages.
  enum class Origin : std::uint8_t { publisher, network };
  /// The ids of the readers of the page, each with the meter of the reader.
  using Page = std::vector<std::pair<std::uint64_t, DeliveryMeter>>;

  // The functions for the agent's thread.

  /// Opens accounts for the readers of the page. Must be called with a page before turn_to() is called with
  /// it.
  void enter(const Page& page);
  /// Adds to the count of retained samples that were sent to a reader at first.
  void retained(std::uint64_t reader, std::uint64_t samples);
  /// Removes the accounts of all readers but `readers`. The removed readers must not come back. From then on
  /// their counts are only in total().
  void keep(const std::set<std::uint64_t>& readers);

  /// `to_come` means that the tallies of the previous page may still increase until the next call of
  /// turn_to(). Then the new page must not have any of these tallies.
  enum class LateCounts : std::uint8_t { none, to_come };

  /// Makes `page` the open page of `origin`. The publisher's thread. Allocates nothing.
  void turn_to(Origin origin, const Page& page, LateCounts late = LateCounts::none) noexcept;

  // The functions for any thread.

  Delivered of(std::uint64_t reader) const;
  /// Returns the counts of all readers together, including departed ones.
  Delivered total() const;

 private:
  struct Counts {  ///< the counts of one origin for one reader
    DeliveryMeter::Reading before{};
    DeliveryMeter::Reading at_first{};  ///< the reading of `meter` when the present page was opened
    DeliveryMeter meter{};
    DeliveryMeter::Reading at_last{};  ///< the reading of `late` when the previous page was closed
    DeliveryMeter late{};              ///< the meter of the previous page, if it may still grow
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
