// The table of gates, which follows the body of a sample in shared memory, since all readers read the same
// sample there. The table names the gates with conditions that the sample has passed, and for each gate the
// sample's number among the samples that passed it. By this number a reader distinguishes lost samples from
// withheld ones. (Over UDP, each datagram names the one gate that its sample has passed, and this number.)
//
// The table is 8-aligned. Each entry has 16 bytes: id of the gate (gate_id()), number, zeros. A sample has
// no table if its chunk is too small for one, which is possible if the program took a loan before the first
// reader with conditions came. Samples that are missing before such a sample count as withheld.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/seam/gate.h"
#include "core/seam/sample_buffer.h"

namespace sft::core {

/// The maximum number of entries in a table. Further gates have no entry.
inline constexpr std::size_t gates_in_table_max = 64;

/// Returns the number of bytes that a table of `gates` gates needs after the end of a sample.
std::size_t gate_table_bytes(std::size_t gates);
/// Returns the offset of the table in a sample of `sample_bytes`.
constexpr std::size_t gate_table_begin(std::size_t sample_bytes) { return (sample_bytes + 7) / 8 * 8; }
/// Returns the size in bytes of a sample of `sample_bytes` bytes together with its table, which may be
/// empty.
std::size_t bytes_with_gate_table(std::size_t sample_bytes, std::size_t gates);

/// Writes a table of the gates in `gates` that the sample has passed. Called by the publisher's thread.
/// `slots` is the number of index slots of the sample's type.
void write_gate_table(SampleBuffer& sample, std::size_t slots, std::span<const std::shared_ptr<Gate>> gates);
/// Returns the sample's number among the samples that passed `gate`, or nothing if the sample did not pass
/// that gate. The function also accepts an invalid table, since another process may have overwritten it.
std::optional<std::uint32_t> ordinal_in_gate(const SampleBuffer& sample, std::size_t slots,
                                             std::uint64_t gate);

}  // namespace sft::core
