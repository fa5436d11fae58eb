// Payloads that other programs recorded. The recordings are not part of the repository, and may be missing on
// a machine.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

namespace sft::test {

using Payload = std::vector<std::byte>;  ///< the encapsulation and the body

/// Returns the directory of the recordings.
std::filesystem::path recorded_data();

/// Returns the content of a file, unpacked if the file's name ends with .xz. Returns nothing if unpacking
/// needs the program xz and it is not installed. Throws if the file cannot be read.
std::optional<Payload> read_recording(const std::filesystem::path& file);

/// Returns the payloads of a .cdrlog file. Each record of the file is u64 time, u32 length, payload.
std::vector<Payload> read_records(const std::filesystem::path& file);

}  // namespace sft::test
