// The id of the network stack that this process is in. It is equal for processes between which 127.0.0.1 is
// the same address. One machine has several network stacks if it runs containers.
#pragma once

#include <cstdint>

namespace sft::core {

/// Hash of the boot's id, and below it, in the lower half, one of the network namespace as well.
std::uint64_t network_id() noexcept;

constexpr bool on_one_machine(std::uint64_t network, std::uint64_t other) {
  return network >> 32 == other >> 32;
}

}  // namespace sft::core
