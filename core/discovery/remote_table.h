// The records of one role that one participant has written, compared with the digests in the heartbeats of
// its process. A heartbeat may be older or newer than the received records, so a single digest that differs
// from the table's proves nothing. The table therefore remembers its own recent digests. If the digests of
// two successive heartbeats match neither these nor any later digest of the table, a record is missing, or
// a record in the table is not the process's own. Uses no clock, thread or I/O. An object must be used by
// only one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "core/discovery/records.h"
#include "core/platform/clock.h"

namespace sft::core {

class RemoteTable {
 public:
  /// Stores a record that has come.
  void put(const RecordKey& key, Record record);
  const Records& records() const { return records_; }

  /// Called when a heartbeat with this digest has come. Heartbeats that come less than `apart` after each
  /// other count as one. Returns true if the table has this digest, or has had it since the last match of
  /// the table with a heartbeat.
  bool expect(std::uint64_t digest, Time::duration apart, Time now);
  /// Returns the time of the second of two successive heartbeats whose digests the table has never had;
  /// nothing if no record is known to be missing.
  std::optional<Time> behind_since() const;
  /// Discards the digests of heartbeats, but keeps the records.
  void expect_nothing() { expected_.clear(); }

 private:
  struct Expected {
    std::uint64_t digest = 0;
    Time since{};
  };
  static constexpr std::size_t passed_max = 1024;  ///< the maximum number of remembered changes between two
                                                   ///< heartbeats
  static constexpr std::size_t expected_max = 16;

  Records records_;
  /// The digests that the table has had since its last match with a heartbeat; the present digest is the
  /// last.
  std::deque<std::uint64_t> passed_;
  /// The digests of heartbeats that the table has not had since they came; the oldest is the first.
  std::deque<Expected> expected_;
};

}  // namespace sft::core
