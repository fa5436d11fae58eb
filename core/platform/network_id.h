// The id of the network stack that this process is in. It is equal for processes between which 127.0.0.1 is
// the same address. One machine has several network stacks if it runs containers.
#pragma once

#include <cstdint>

namespace sft::core {

/// Returns the id. The upper half is a hash of the boot id, so that it identifies the machine. The lower half
/// also depends on the network namespace.
std::uint64_t network_id() noexcept;

constexpr bool on_one_machine(std::uint64_t network, std::uint64_t other) {
  return network >> 32 == other >> 32;
}

}  // namespace sft::core
