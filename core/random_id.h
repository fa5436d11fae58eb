// Ids that are unique without asking anybody: endpoints, doorbell pages, control sequences of incarnations.
#pragma once

#include <cstdint>

namespace sft::core {

/// 64 random bits of the kernel's, never 0. Aborts nothing: falls back to time and address where getrandom
/// fails.
std::uint64_t random_id() noexcept;

}  // namespace sft::core
