// Huge pages for memory for which this process requests them (MADV_HUGEPAGE).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace sft::core {

/// The minimum size in bytes of the memory blocks for which huge pages are requested.
inline constexpr std::size_t huge_page_bytes = std::size_t{2} << 20;

/// Returns the reason why the system gives no huge pages to memory that requests them. The result is empty
/// if the system does so as long as it has free ones.
std::string why_no_huge_pages(const std::filesystem::path& root = "/");

}  // namespace sft::core
