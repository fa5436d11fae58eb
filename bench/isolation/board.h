// The notes of all processes of a run, in memory that they share.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace sft::bench::isolation {

inline constexpr std::size_t local_readers = 3;
inline constexpr std::size_t remote_reader = local_readers;  ///< its place behind the local ones
inline constexpr std::size_t messages_max = 8192;

/// The index in an array is the number of a message. Numbers begin at 1.
struct Board {
  std::atomic<std::size_t> ready{0};            ///< processes that are matched, without the remote reader
  std::atomic<bool> begun{false};               ///< the publisher may write
  std::atomic<std::uint64_t> written{0};        ///< the number of the last message whose turn has come
  std::atomic<std::uint64_t> remote_latest{0};  ///< the greatest number that the remote reader has read
  std::atomic<bool> remote_matched{false};
  std::int64_t due_ns[messages_max] = {};
  std::int64_t sent_ns[messages_max] = {};                        ///< before the call that writes
  std::int64_t returned_ns[messages_max] = {};                    ///< after it; 0: it has not returned
  std::int64_t page_faults[messages_max] = {};                    ///< of the publisher's thread in that call
  std::int64_t arrived_ns[local_readers + 1][messages_max] = {};  ///< 0: not read
};

}  // namespace sft::bench::isolation
