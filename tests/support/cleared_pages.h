// Measures the part of a mapping of a file in memory that was cleared.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace sft::test {

/// Returns the size of a page in bytes. On arm64 it is 4, 16 or 64 KiB.
inline std::size_t page_bytes() { return static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)); }

/// Returns the size in bytes of the pages that any process has cleared or written, or 0 if the system does
/// not report these pages. mincore() does not count pages that are only reserved.
inline std::size_t cleared_bytes(std::span<const std::byte> mapping) {
  std::vector<unsigned char> pages((mapping.size() + page_bytes() - 1) / page_bytes());
  if (mincore(const_cast<std::byte*>(mapping.data()), mapping.size(), pages.data()) != 0) return 0;
  const auto cleared = std::ranges::count_if(pages, [](unsigned char page) { return (page & 1U) != 0; });
  return page_bytes() * static_cast<std::size_t>(cleared);
}

}  // namespace sft::test
