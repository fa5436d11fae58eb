// The status of sftd, which `sftd status` prints: the programs that use the memory, and the amount of
// memory that each program uses. The members have the names of the keys in JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sft::shm {

struct Versions {
  std::string sftd{};
  std::string iceoryx{};
  std::uint32_t protocol = 0;  ///< host_protocol of the daemon (host_file.h)
};

struct PoolUse {
  std::uint64_t bytes = 0;   ///< the largest sample in a chunk: header, index and body
  std::uint32_t chunks = 0;  ///< the number of chunks
  std::uint32_t in_use = 0;
  std::uint32_t peak = 0;  ///< the exact maximum number of chunks in use at a time since the daemon started
};

/// A program that uses the daemon.
struct UserUse {
  std::int64_t pid = 0;  ///< pid in the program's own pid namespace
  std::string name{};
  std::uint32_t publishers = 0;
  std::uint32_t subscribers = 0;
};

/// The chunks that one port holds.
struct Holding {
  std::uint32_t chunks = 0;
  /// The maximum number of chunks in all measurements; the daemon measures ten times a second.
  std::uint32_t peak = 0;
  std::uint64_t bytes = 0;  ///< the memory of these chunks; the samples in them may be smaller
};

struct PublisherUse {
  std::string user{};       ///< the name of the publisher's program
  std::string publisher{};  ///< the id of the publisher, in hex
  std::uint32_t subscribers = 0;
  Holding held{};  ///< chunks of loans, the history, sends to other hosts, and the last sample
};

/// The connection of one subscriber to one publisher.
struct SubscriberUse {
  std::string user{};         ///< the name of the subscriber's program
  std::string publisher{};    ///< the id of the publisher, in hex
  std::uint32_t waiting = 0;  ///< number of samples in its queue; they occupy chunks, too
  Holding held{};             ///< samples that were taken and not yet released
};

struct Usage {
  std::vector<PoolUse> pools{};
  std::vector<UserUse> users{};
  std::vector<PublisherUse> publishers{};
  std::vector<SubscriberUse> subscribers{};
  /// Number of chunks that killed programs had in hand and that the daemon has freed.
  std::uint64_t leaks_healed = 0;
  /// Number of locks that killed programs still held and that the daemon has released.
  std::uint64_t locks_healed = 0;
  std::uint64_t deaths = 0;     ///< number of programs that ended without a goodbye
  std::uint64_t unaudited = 0;  ///< number of deaths since the last search for lost chunks
  std::int64_t stamp_ns = 0;    ///< the time of this status, by CLOCK_REALTIME
};

struct Status {
  std::int64_t pid = 0;
  Versions versions{};
  std::int64_t since_ns = 0;     ///< the time when the daemon started, by CLOCK_REALTIME
  std::int64_t idle_exit_s = 0;  ///< time without clients after which the daemon ends, in seconds; 0: never
  std::string writers{};         ///< the group that may publish
  std::string readers{};         ///< the group that may only subscribe; empty: there is no such group
  std::uint64_t sample_bytes = 0;
  std::uint64_t management_bytes = 0;
  Usage usage{};
};

std::string to_json(const Status& status);
std::optional<Status> parse_status(std::string_view json);
/// Returns a table as text. `now_ns` is the current time by CLOCK_REALTIME.
std::string to_table(const Status& status, std::int64_t now_ns);

}  // namespace sft::shm
