#include "tools/terminal/units.h"

#include <fmt/format.h>

#include <cmath>

namespace sft::tool {

namespace {

struct Size {
  double value;
  const char* unit;
};

Size size_of(double bytes) {
  if (bytes < 1e3) return {bytes, "B"};
  if (bytes < 1e6) return {bytes / 1e3, "kB"};
  if (bytes < 1e9) return {bytes / 1e6, "MB"};
  if (bytes < 1e12) return {bytes / 1e9, "GB"};
  return {bytes / 1e12, "TB"};
}

}  // namespace

std::string bytes_text(double bytes) {
  const auto [value, unit] = size_of(bytes);
  if (bytes < 1e3) return fmt::format("{:.0f} {}", value, unit);
  return bytes < 1e9 ? fmt::format("{:.3g} {}", value, unit) : fmt::format("{:.3f} {}", value, unit);
}

std::string aligned_bytes_text(double bytes) {
  const auto [value, unit] = size_of(bytes);
  return fmt::format("{:.{}f} {}", value, bytes < 1e3 ? 0 : 2, unit);
}

std::string duration_text(double seconds) {
  const double size = std::abs(seconds);
  if (size < 1e-3) return fmt::format("{:.1f} us", seconds * 1e6);
  if (size < 1) return fmt::format("{:.2f} ms", seconds * 1e3);
  return fmt::format("{:.3f} s", seconds);
}

std::string rate_text(double hz) {
  return hz < 10 ? fmt::format("{:.2f} Hz", hz) : fmt::format("{:.1f} Hz", hz);
}

std::string hex_text(std::uint64_t number) { return fmt::format("{:016x}", number); }

std::string percent_text(double part, double whole, int decimals) {
  const double scale = std::pow(10, decimals);
  const double percent = whole > 0 ? std::floor(100 * scale * part / whole) / scale : 0;
  return fmt::format("{:.{}f} %", percent, decimals);
}

std::string short_count_text(std::uint64_t count, std::size_t width) {
  std::string digits = std::to_string(count);
  return digits.size() <= width ? digits : fmt::format("{:.1e}", static_cast<double>(count));
}

std::string grouped_count_text(std::uint64_t count) {
  std::string text = std::to_string(count);
  for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > 0; at -= 3)
    text.insert(static_cast<std::size_t>(at), ",");
  return text;
}

std::string count_text(std::size_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

}  // namespace sft::tool
