// Ids that are unique without asking anybody: endpoints, doorbell pages, control sequences of incarnations.
#pragma once

#include <cstdint>
#include <string>

namespace sft::core {

/// 64 random bits of the kernel's, never 0. Aborts nothing: falls back to time and address where getrandom
/// fails.
std::uint64_t random_id() noexcept;

/// An id in names of files and services: 16 digits.
std::string in_hex(std::uint64_t id);

}  // namespace sft::core
