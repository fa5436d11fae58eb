// Huge pages for memory of this process that asks for them (MADV_HUGEPAGE).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace sft::core {

/// Blocks of memory that are at least as large ask for huge pages.
inline constexpr std::size_t huge_page_bytes = std::size_t{2} << 20;

/// Empty: such memory lies in huge pages, as far as the system has some free. Or else why not.
std::string why_no_huge_pages(const std::filesystem::path& root = "/");

}  // namespace sft::core
