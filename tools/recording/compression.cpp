#include "tools/recording/compression.h"

#include <libdeflate.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

namespace sft::recording {

namespace {

constexpr int zstd_level = 1;  // higher levels are slower than sensors, and save little with their data
// the least number of bytes by which the buffer grows
constexpr std::size_t step_bytes = std::size_t{1} << 20;

Result<Bytes> wrong_size(std::uint64_t size) {
  return fail(Errc::malformed,
              "its contents do not have the " + std::to_string(size) + " bytes that it says");
}

/// Fills a buffer by calls of `more`, and makes it larger when it is full. `more` receives the free part of
/// the buffer, sets the number of bytes that it has written, and returns true at the end of the data. The
/// buffer at least doubles each time, but never exceeds `size` by more than one byte.
template <class More>
Result<Bytes> decompressed(std::uint64_t size, const More& more) {
  Bytes out;
  std::size_t used = 0;
  for (;;) {
    if (used == out.size()) {
      const std::uint64_t grown = std::max<std::uint64_t>(step_bytes, 2 * std::uint64_t{used});
      // One more byte than `size` is allowed, in order to detect that the contents are larger.
      out.resize(static_cast<std::size_t>(std::min<std::uint64_t>(grown, size + 1)));
      if (used == out.size()) return wrong_size(size);
    }
    std::size_t written = 0;
    const Result<bool> at_end = more(std::span(out).subspan(used), written);
    if (!at_end) return tl::unexpected(at_end.error());
    used += written;
    if (used > size) return wrong_size(size);
    if (*at_end) break;
  }
  if (used != size) return wrong_size(size);
  out.resize(used);
  return out;
}

Result<Bytes> from_zstd(std::span<const std::byte> bytes, std::uint64_t size) {
  const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                          &ZSTD_freeDStream);
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  return decompressed(size, [&](std::span<std::byte> room, std::size_t& written) -> Result<bool> {
    ZSTD_outBuffer out{room.data(), room.size(), 0};
    const std::size_t left = ZSTD_decompressStream(stream.get(), &out, &in);
    if (ZSTD_isError(left) != 0)
      return fail(Errc::malformed, std::string("zstd refuses it: ") + ZSTD_getErrorName(left));
    written = out.pos;
    if (left == 0 && in.pos == in.size) return true;
    if (out.pos < out.size && in.pos == in.size) return fail(Errc::malformed, "its zstd data end early");
    return false;
  });
}

Result<Bytes> from_lz4(std::span<const std::byte> bytes, std::uint64_t size) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0)
    return fail(Errc::out_of_memory, "lz4 has no memory");
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      made, &LZ4F_freeDecompressionContext);
  return decompressed(size, [&](std::span<std::byte> room, std::size_t& written) -> Result<bool> {
    std::size_t in = bytes.size();
    written = room.size();
    const std::size_t left = LZ4F_decompress(made, room.data(), &written, bytes.data(), &in, nullptr);
    if (LZ4F_isError(left) != 0)
      return fail(Errc::malformed, std::string("lz4 refuses it: ") + LZ4F_getErrorName(left));
    bytes = bytes.subspan(in);
    if (left == 0 && bytes.empty()) return true;
    if (written < room.size() && bytes.empty()) return fail(Errc::malformed, "its lz4 data end early");
    return false;
  });
}

}  // namespace

std::string_view name_of(Compression compression) {
  constexpr std::string_view names[] = {"", "lz4", "zstd"};
  return names[static_cast<std::size_t>(compression)];
}

std::uint32_t crc32(std::uint32_t crc, std::span<const std::byte> bytes) {
  if (bytes.empty()) return crc;  // if the pointer were null, libdeflate would begin anew
  return libdeflate_crc32(crc, bytes.data(), bytes.size());
}

Result<void> compress(Compression compression, std::span<const std::byte> bytes, Bytes& to) {
  const std::size_t before = to.size();
  std::size_t written = 0;
  const char* fault = nullptr;
  if (compression == Compression::none) {
    to.insert(to.end(), bytes.begin(), bytes.end());
    return {};
  }
  if (compression == Compression::zstd) {
    to.resize(before + ZSTD_compressBound(bytes.size()));
    written = ZSTD_compress(to.data() + before, to.size() - before, bytes.data(), bytes.size(), zstd_level);
    if (ZSTD_isError(written) != 0) fault = ZSTD_getErrorName(written);
  } else {
    to.resize(before + LZ4F_compressFrameBound(bytes.size(), nullptr));
    written = LZ4F_compressFrame(to.data() + before, to.size() - before, bytes.data(), bytes.size(), nullptr);
    if (LZ4F_isError(written) != 0) fault = LZ4F_getErrorName(written);
  }
  if (fault != nullptr) return fail(Errc::system, std::string("the samples cannot be compressed: ") + fault);
  to.resize(before + written);
  return {};
}

Result<Bytes> decompress(std::string_view name, std::span<const std::byte> bytes, std::uint64_t size) {
  if (name == "zstd") return from_zstd(bytes, size);
  if (name == "lz4") return from_lz4(bytes, size);
  if (!name.empty()) {
    return fail(Errc::malformed, "its compression is unknown; MCAP has zstd and lz4");
  }
  if (bytes.size() != size) return wrong_size(size);
  return Bytes(bytes.begin(), bytes.end());
}

}  // namespace sft::recording
