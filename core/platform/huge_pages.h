// Huge pages for memory of this process that asks for them (MADV_HUGEPAGE).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace sft::core {

/// Blocks of memory that have at least this size ask for huge pages.
inline constexpr std::size_t huge_page_bytes = std::size_t{2} << 20;

/// Returns why such memory does not get huge pages. Empty: it does, as far as the system has free ones.
std::string why_no_huge_pages(const std::filesystem::path& root = "/");

}  // namespace sft::core
