// Ids that are unique without any coordination: for endpoints, doorbell pages, control sequences of
// incarnations.
#pragma once

#include <cstdint>
#include <string>

namespace sft::core {

/// Returns 64 random bits of the kernel, never 0. If getrandom() fails, it uses the time and an address
/// instead.
std::uint64_t random_id() noexcept;

/// Returns an id as in names of files and services: 16 hex digits.
std::string in_hex(std::uint64_t id);

}  // namespace sft::core
