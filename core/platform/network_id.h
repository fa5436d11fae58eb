// The id of the network stack of this process. Two processes have equal ids if 127.0.0.1 is the same address
// for both. A machine that runs containers has several network stacks.
#pragma once

#include <cstdint>
#include <optional>

namespace sft::core {

/// Returns the id. The upper half is a hash of the boot id, and so identifies the machine. The lower half
/// depends on the boot id and the network namespace. Returns nothing without /proc, which names both.
std::optional<std::uint64_t> network_id() noexcept;

constexpr bool on_one_machine(std::uint64_t network, std::uint64_t other) {
  return network >> 32 == other >> 32;
}

}  // namespace sft::core
