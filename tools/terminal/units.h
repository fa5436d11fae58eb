// Formats numbers as text for people.
#pragma once

#include <cstdint>
#include <string>

namespace sft::tool {

std::string bytes_text(double bytes);  ///< text such as "82 B", "6.29 MB", "72 MB"
/// Returns text with two decimals, so that a column of sizes can be compared: "82 B", "6.29 MB", "72.00 MB".
std::string aligned_bytes_text(double bytes);
std::string duration_text(double seconds);   ///< text such as "1.23 ms", "-4.00 us"
std::string rate_text(double hz);            ///< text such as "10.0 Hz"
std::string hex_text(std::uint64_t number);  ///< an id as 16 hex digits
/// Returns a text like "99.98 %". It is rounded down, so that "100 %" always means the whole.
std::string percent_text(double part, double whole, int decimals);
/// Returns a count in at most `width` columns: "1234567", "1.2e+09". REQUIRES: `width` is at least 7.
std::string short_count_text(std::uint64_t count, std::size_t width);
/// Returns a text like "6,291,725".
std::string grouped_count_text(std::uint64_t count);
/// Returns a text like "1 topic" or "2 topics".
std::string count_text(std::size_t count, const char* noun);

}  // namespace sft::tool
