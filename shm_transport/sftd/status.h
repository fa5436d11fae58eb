// What `sftd status` tells: who uses the memory, and who has how much of it.
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
  std::uint32_t protocol = 0;  ///< between sftd and programs (host_file.h)
};

struct PoolUse {
  std::uint64_t bytes = 0;  ///< of a sample: header, index and body
  std::uint32_t chunks = 0;
  std::uint32_t in_use = 0;
  std::uint32_t peak = 0;  ///< exact, since the daemon began
};

struct UserUse {
  std::int64_t pid = 0;  ///< in the program's own pid namespace
  std::string name{};
  std::uint32_t publishers = 0;
  std::uint32_t subscribers = 0;
};

/// Chunks that one port has. `peak`: the most that were seen in ten looks a second.
struct Holding {
  std::uint32_t chunks = 0;
  std::uint32_t peak = 0;
  std::uint64_t bytes = 0;  ///< of the pools, not of the samples in them
};

struct PublisherUse {
  std::string user{};
  std::string publisher{};  ///< its id, in hex
  std::uint32_t subscribers = 0;
  Holding held{};  ///< loans, history, sends to other hosts, and the last sample
};

/// One publisher's samples for one subscriber.
struct SubscriberUse {
  std::string user{};
  std::string publisher{};
  std::uint32_t waiting = 0;  ///< in its queue: chunks, too
  Holding held{};             ///< samples that were taken and not let go of
};

struct Usage {
  std::vector<PoolUse> pools{};
  std::vector<UserUse> users{};
  std::vector<PublisherUse> publishers{};
  std::vector<SubscriberUse> subscribers{};
  std::uint64_t leaks_healed = 0;  ///< chunks that killed programs had in hand
  std::uint64_t locks_healed = 0;  ///< that killed programs had left closed
  std::uint64_t deaths = 0;        ///< programs that ended without a goodbye
  std::uint64_t unaudited = 0;     ///< of these: each may have left a chunk that was not looked for yet
  std::int64_t stamp_ns = 0;       ///< CLOCK_REALTIME when all this was so
};

struct Status {
  std::int64_t pid = 0;
  Versions versions{};
  std::int64_t since_ns = 0;     ///< CLOCK_REALTIME
  std::int64_t idle_exit_s = 0;  ///< 0: never
  std::string writers{};         ///< the group that may publish
  std::string readers{};         ///< the one that may only read; empty: none
  std::uint64_t sample_bytes = 0;
  std::uint64_t management_bytes = 0;
  Usage usage{};
};

std::string to_json(const Status& status);
std::optional<Status> parse_status(std::string_view json);
/// For people; `now_ns` on the clock of the stamps.
std::string to_table(const Status& status, std::int64_t now_ns);

}  // namespace sft::shm
