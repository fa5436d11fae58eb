// What one participant has written of one role, compared with the digests that its process gives in
// heartbeats. A heartbeat may be older than the records that have come, or newer. So one digest that differs
// proves nothing. Two heartbeats in turn whose digests the table has had neither before nor since do: then a
// record is missing, or one is not the process's own. Pure. One thread at a time.
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
  /// A record has come.
  void put(const RecordKey& key, Record record);
  const Records& records() const { return records_; }

  /// A heartbeat counts records with this digest. Heartbeats that are not `apart` count as one. Returns true
  /// if the table has had that digest since the last one that it has had.
  bool expect(std::uint64_t digest, Time::duration apart, Time now);
  /// Returns the time of the second of two such heartbeats; nothing if all has come as far as is known.
  std::optional<Time> behind_since() const;
  /// Forgets what heartbeats have said. The records stay.
  void expect_nothing() { expected_.clear(); }

 private:
  struct Expected {
    std::uint64_t digest = 0;
    Time since{};
  };
  static constexpr std::size_t passed_max = 1024;  ///< changes between two heartbeats that are told apart
  static constexpr std::size_t expected_max = 16;

  Records records_;
  /// The digests that the table has had since the last one that a heartbeat has given; the present one is the
  /// last.
  std::deque<std::uint64_t> passed_;
  /// What heartbeats have given and the table has not had since; the oldest is the first.
  std::deque<Expected> expected_;
};

}  // namespace sft::core
