// Payloads that others recorded, where they are on this machine (they are not part of the repository).
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

namespace sft::test {

using Payload = std::vector<std::byte>;  ///< encapsulation and body

/// The directory in which recordings are looked for.
std::filesystem::path recorded_data();

/// The whole of a file; one called .xz unpacked, or nothing where there is no xz.
std::optional<Payload> read_recording(const std::filesystem::path& file);

/// The records of a .cdrlog file: u64 time, u32 length, payload, and again.
std::vector<Payload> read_records(const std::filesystem::path& file);

}  // namespace sft::test
