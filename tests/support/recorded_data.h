// Payloads that other programs recorded. They are not part of the repository, and may be missing on a
// machine.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

namespace sft::test {

using Payload = std::vector<std::byte>;  ///< encapsulation and body

/// Returns the directory of the recordings.
std::filesystem::path recorded_data();

/// Returns the content of a file, unpacked if its name ends with .xz. Empty if that needs the program xz,
/// which is not installed. Throws if the file cannot be read.
std::optional<Payload> read_recording(const std::filesystem::path& file);

/// Returns the payloads of a .cdrlog file. Each of its records is u64 time, u32 length, payload.
std::vector<Payload> read_records(const std::filesystem::path& file);

}  // namespace sft::test
