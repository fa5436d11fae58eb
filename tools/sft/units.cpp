#include "tools/sft/units.h"

#include <fmt/format.h>

#include <cmath>

namespace sft::tool {

std::string bytes_text(double bytes) {
  if (bytes < 1e3) return fmt::format("{:.0f} B", bytes);
  if (bytes < 1e6) return fmt::format("{:.3g} kB", bytes / 1e3);
  if (bytes < 1e9) return fmt::format("{:.3g} MB", bytes / 1e6);
  if (bytes < 1e12) return fmt::format("{:.3f} GB", bytes / 1e9);
  return fmt::format("{:.3f} TB", bytes / 1e12);
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

std::string count_text(std::size_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

}  // namespace sft::tool
