// What a request says beside its mask, as bytes: entries of u8 kind, u16 length (little-endian) and so many
// bytes, each kind once, ascending. A request without entries is one for whole fields of every sample.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/control/control.h"

namespace sft::core {

/// The kinds of entries. Kinds from 128 on may be left out by whoever does not know them; others may not.
enum class WantKind : std::uint8_t {
  period = 1,  ///< Request::min_period_us, as u32, little-endian
  parts = 2    ///< Request::parts, with conditions
};
inline constexpr std::uint8_t optional_wants = 128;

/// Parts that are too large for `wants` are left out.
std::vector<std::byte> wants_of(const Request& request);
/// Fills in what the bytes say. False if they are malformed, or say something unknown that must be known.
bool take_wants(std::span<const std::byte> wants, Request& request);

}  // namespace sft::core
