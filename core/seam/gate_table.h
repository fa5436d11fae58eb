// The table of gates that stands behind the body of a sample in shared memory, where all readers find the
// same sample. It names the gates with conditions that the sample has passed, and the sample's number among
// those that passed each gate. A reader tells by it what was lost from what was withheld. Over UDP, each
// datagram says that of the one gate that it has passed.
//
// The table is 8-aligned. Each entry has 16 bytes: id of the gate (gate_id()), number, zeros. A sample has no
// table if its chunk has no room for one: a program may have filled its loan before the first reader with
// conditions came. What is missing in front of such a sample counts as withheld.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/seam/gate.h"
#include "core/seam/sample_buffer.h"

namespace sft::core {

/// More gates than that have no entry.
inline constexpr std::size_t gates_in_table_max = 64;

/// The bytes to ask for beyond those of a sample, for a table of so many gates.
std::size_t gate_table_bytes(std::size_t gates);
/// Returns where the table begins of a sample that has so many bytes.
constexpr std::size_t gate_table_begin(std::size_t sample_bytes) { return (sample_bytes + 7) / 8 * 8; }
/// The bytes from the beginning of a sample of `sample_bytes` to the end of its table, which may be empty.
std::size_t bytes_with_gate_table(std::size_t sample_bytes, std::size_t gates);

/// Writes those of the gates that the sample has passed, on the publisher's thread. The sample's type has so
/// many slots.
void write_gate_table(SampleBuffer& sample, std::size_t slots, std::span<const std::shared_ptr<Gate>> gates);
/// The sample's number among those that passed the gate, if it passed. The table may be hostile.
std::optional<std::uint32_t> ordinal_in_gate(const SampleBuffer& sample, std::size_t slots,
                                             std::uint64_t gate);

}  // namespace sft::core
