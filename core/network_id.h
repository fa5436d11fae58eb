// Which network stack this process is in: equal for processes between which 127.0.0.1 is the same address.
#pragma once

#include <cstdint>

namespace sft::core {

/// Hash of the boot's id and of the network namespace.
std::uint64_t network_id() noexcept;

}  // namespace sft::core
