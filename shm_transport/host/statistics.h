// What a transport and its ports count together; read by tools while they count.
#pragma once

#include <atomic>
#include <cstdint>

namespace sft::shm {

struct Statistics {
  std::atomic<std::uint64_t> malformed{0};  ///< chunks that are no sample of the reader's type
  std::atomic<std::uint64_t> over_limit{
      0};  ///< loans and takes refused, samples dropped, to stay within a limit
};

}  // namespace sft::shm
