// The compression of chunks, and the checksum of MCAP.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "sft/result.h"
#include "tools/recording/bytes.h"

namespace sft::recording {

enum class Compression : std::uint8_t { none, lz4, zstd };

/// The name in a chunk: "", "lz4" or "zstd".
std::string_view name_of(Compression compression);

/// The CRC-32 of zlib over what `crc` is about and these bytes; `crc` is 0 at first.
std::uint32_t crc32(std::uint32_t crc, std::span<const std::byte> bytes);

/// Appends the compressed bytes to `to`.
Result<void> compress(Compression compression, std::span<const std::byte> bytes, Bytes& to);

/// Returns what was compressed. The bytes may be hostile: memory grows with what they really contain, and
/// never beyond `size`, which is what they are said to contain. The error says what is wrong.
Result<Bytes> decompress(std::string_view name, std::span<const std::byte> bytes, std::uint64_t size);

}  // namespace sft::recording
