// Ids that are unique without any coordination: for endpoints, doorbell pages, and the control sequences of
// processes.
#pragma once

#include <cstdint>
#include <string>

namespace sft::core {

/// Returns 64 random bits from the kernel, never 0. If getrandom() fails, the result is made from the time
/// and an address.
std::uint64_t random_id() noexcept;

/// Returns an id as 16 hex digits, as in names of files and services.
std::string in_hex(std::uint64_t id);

}  // namespace sft::core
