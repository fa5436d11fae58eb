// The counters that a transport shares with its ports. Tools read them while the ports increment them.
#pragma once

#include <atomic>
#include <cstdint>

namespace sft::shm {

struct Statistics {
  std::atomic<std::uint64_t> malformed{0};  ///< number of chunks that are no sample of the reader's type
  /// Number of loans and takes that were refused, and of samples that were dropped, to stay within a limit.
  std::atomic<std::uint64_t> over_limit{0};
};

}  // namespace sft::shm
