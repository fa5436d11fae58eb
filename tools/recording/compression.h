// The compression of chunks, and the checksum of MCAP.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "sft/result.h"
#include "tools/recording/bytes.h"

namespace sft::recording {

enum class Compression : std::uint8_t { none, lz4, zstd };

/// Returns the name of the compression as chunks have it: "", "lz4" or "zstd".
std::string_view name_of(Compression compression);

/// Returns the CRC-32 of zlib for the bytes of earlier calls, whose result is `crc`, and these bytes. For
/// the first bytes, `crc` is 0.
std::uint32_t crc32(std::uint32_t crc, std::span<const std::byte> bytes);

/// Appends the compressed bytes to `to`.
Result<void> compress(Compression compression, std::span<const std::byte> bytes, Bytes& to);

/// Returns the uncompressed contents. The bytes may be hostile: the memory grows with the real contents,
/// and never beyond `size`, which is their announced size. The error says what is wrong.
Result<Bytes> decompress(std::string_view name, std::span<const std::byte> bytes, std::uint64_t size);

}  // namespace sft::recording
