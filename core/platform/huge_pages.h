// Huge pages for memory of this process that asks for them (MADV_HUGEPAGE).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace sft::core {

/// The least size of the blocks of memory that ask for huge pages.
inline constexpr std::size_t huge_page_bytes = std::size_t{2} << 20;

/// Returns the reason why such memory does not get huge pages. The result is empty if the memory gets them,
/// as far as the system has free ones.
std::string why_no_huge_pages(const std::filesystem::path& root = "/");

}  // namespace sft::core
