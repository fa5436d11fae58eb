// Measures how much of the mapping of a file in memory is cleared.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace sft::test {

/// Returns the size of a page, which is 4, 16 or 64 KiB on arm64.
inline std::size_t page_bytes() { return static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)); }

/// Returns the bytes of the pages that any process has cleared or written; 0 if the system does not say.
/// mincore() does not count pages that are only reserved.
inline std::size_t cleared_bytes(std::span<const std::byte> mapping) {
  std::vector<unsigned char> pages((mapping.size() + page_bytes() - 1) / page_bytes());
  if (mincore(const_cast<std::byte*>(mapping.data()), mapping.size(), pages.data()) != 0) return 0;
  const auto cleared = std::ranges::count_if(pages, [](unsigned char page) { return (page & 1U) != 0; });
  return page_bytes() * static_cast<std::size_t>(cleared);
}

}  // namespace sft::test
