// The resources that a process holds.
#pragma once

#include <malloc.h>

#include <cstdint>
#include <filesystem>
#include <iterator>
#include <system_error>

namespace sft::test {

inline std::int64_t entries_of(const char* directory) {
  std::error_code error;
  const auto entries = std::filesystem::directory_iterator(directory, error);
  return error ? 0 : std::distance(begin(entries), end(entries));
}

struct Holdings {
  std::int64_t bytes = 0;  ///< the memory that its allocators have lent
  std::int64_t descriptors = 0, threads = 0;

  Holdings operator-(const Holdings& other) const {
    return {bytes - other.bytes, descriptors - other.descriptors, threads - other.threads};
  }
  static Holdings of_this_process() {
    const struct mallinfo2 heap = mallinfo2();
    return {static_cast<std::int64_t>(heap.uordblks + heap.hblkhd), entries_of("/proc/self/fd"),
            entries_of("/proc/self/task")};
  }
};

}  // namespace sft::test
