// The records of one role that one participant has written, compared with the digests in the heartbeats of
// its process. A heartbeat may be older or newer than the records that have come, so a single digest that
// differs proves nothing. But if the table has had the digests of two successive heartbeats neither before
// nor since, a record is missing, or one is not the process's own. Uses no clock, thread or I/O. One thread
// at a time.
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

  /// A heartbeat with this digest has come. Heartbeats less than `apart` from each other count as one.
  /// Returns true if the table has this digest, or has had it since it last had the digest of a heartbeat.
  bool expect(std::uint64_t digest, Time::duration apart, Time now);
  /// Returns the time of the second of two heartbeats whose digests the table has not had; nothing if no
  /// record is known to be missing.
  std::optional<Time> behind_since() const;
  /// Discards the digests of heartbeats. The records stay.
  void expect_nothing() { expected_.clear(); }

 private:
  struct Expected {
    std::uint64_t digest = 0;
    Time since{};
  };
  static constexpr std::size_t passed_max = 1024;  ///< remembered changes between two heartbeats
  static constexpr std::size_t expected_max = 16;

  Records records_;
  /// The digests that the table has had since it last had that of a heartbeat; the present one is the last.
  std::deque<std::uint64_t> passed_;
  /// The digests of heartbeats that the table has not had since; the oldest is the first.
  std::deque<Expected> expected_;
};

}  // namespace sft::core
