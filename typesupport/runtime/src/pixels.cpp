#include "pixels.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>

namespace sft::detail {

namespace {

/// The index of a pattern is twice the parity of the row plus the parity of the column at which the part
/// begins.
constexpr std::array<const char*, 4> bayer_patterns{"rggb", "grbg", "gbrg", "bggr"};
constexpr std::string_view bayer = "bayer_";
constexpr std::uint32_t samples_max = 512;  // the maximum number of values in a pixel, in OpenCV

struct KnownPixels {
  std::string_view encoding;
  std::uint32_t bytes;
};
constexpr KnownPixels singles[] = {{"mono8", 1}, {"mono16", 2}, {"rgb8", 3},  {"bgr8", 3},   {"rgba8", 4},
                                   {"bgra8", 4}, {"rgb16", 6},  {"bgr16", 6}, {"rgba16", 8}, {"bgra16", 8}};
constexpr std::string_view pairs[] = {"yuv422", "yuv422_yuy2", "uyvy", "yuyv"};
constexpr std::string_view planes[] = {"nv12", "nv21", "nv24"};

bool is_one_of(std::string_view name, std::span<const std::string_view> names) {
  return std::ranges::find(names, name) != names.end();
}

/// Returns the size in bytes of a pixel in an encoding of OpenCV, "8UC3" or "32FC1"; 0 if the name is not
/// that of such an encoding.
std::uint32_t opencv_bytes(std::string_view encoding) {
  std::uint32_t bits = 0;
  const char* const end = encoding.data() + encoding.size();
  const auto [behind_bits, error] = std::from_chars(encoding.data(), end, bits);
  const std::string_view rest(behind_bits, static_cast<std::size_t>(end - behind_bits));
  if (error != std::errc() || rest.size() < 3 || rest[1] != 'C') return 0;
  const bool is_kind = rest[0] == 'F' ? bits == 32 || bits == 64
                                      : (rest[0] == 'S' || (rest[0] == 'U' && bits < 32)) &&
                                            (bits == 8 || bits == 16 || bits == 32);
  std::uint32_t samples = 0;
  const auto read = std::from_chars(rest.data() + 2, end, samples);
  if (!is_kind || read.ec != std::errc() || read.ptr != end || samples > samples_max) return 0;
  return bits / 8 * samples;
}

}  // namespace

Pixels Pixels::of(std::string_view encoding) {
  Pixels pixels;
  if (is_one_of(encoding, planes)) {
    pixels.order_ = Order::planes;
  } else if (is_one_of(encoding, pairs)) {
    pixels.order_ = Order::pairs;
    pixels.bytes_ = 2;
  } else if (encoding.starts_with(bayer)) {
    const std::string_view rest = encoding.substr(bayer.size());
    const auto pattern = std::ranges::find(bayer_patterns, rest.substr(0, 4),
                                           [](const char* name) { return std::string_view(name); });
    const std::string_view bits = rest.substr(std::min<std::size_t>(rest.size(), 4));
    if (pattern == bayer_patterns.end() || (bits != "8" && bits != "16")) return pixels;
    pixels.order_ = Order::bayer;
    pixels.pattern_ = static_cast<std::uint8_t>(pattern - bayer_patterns.begin());
    pixels.bytes_ = bits == "8" ? 1 : 2;
  } else {
    const auto known = std::ranges::find(singles, encoding, &KnownPixels::encoding);
    pixels.bytes_ = known == std::end(singles) ? opencv_bytes(encoding) : known->bytes;
    pixels.order_ = pixels.bytes_ == 0 ? Order::unknown : Order::single;
  }
  return pixels;
}

std::uint64_t Pixels::bytes_in(const Image& image) const {
  if (order_ != Order::unknown) return bytes_;
  const bool is_known = image.columns != 0 && image.row_bytes % image.columns == 0 &&
                        image.rows * image.row_bytes == image.data_bytes;
  return is_known ? image.row_bytes / image.columns : 0;
}

bool Pixels::have(const Selection::Range& rows, const Selection::Range& columns, std::uint64_t count) const {
  if (order_ == Order::bayer) return rows.step % 2 == 1 && columns.step % 2 == 1;
  if (order_ != Order::pairs) return true;
  const std::uint32_t kept = columns.size_of(static_cast<std::uint32_t>(count));
  return columns.step == 1 && columns.begin % 2 == 0 && kept % 2 == 0;
}

const char* Pixels::pattern_at(std::uint32_t row, std::uint32_t column) const {
  if (order_ != Order::bayer) return nullptr;
  return bayer_patterns[pattern_ ^ (row % 2 * 2 + column % 2)];
}

}  // namespace sft::detail
