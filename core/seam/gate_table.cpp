#include "core/seam/gate_table.h"

#include <algorithm>
#include <cstring>

#include "sft/detail/sample_format.h"

namespace sft::core {

namespace {

struct Entry {
  std::uint64_t gate = 0;
  std::uint32_t ordinal = 0;
  std::uint32_t zero = 0;
};
static_assert(sizeof(Entry) == 16);

std::size_t sample_bytes(const SampleBuffer& sample, std::size_t slots) {
  return detail::SampleLayout(slots).bytes(state_of(sample, slots).body_bytes);
}

}  // namespace

std::size_t gate_table_bytes(std::size_t gates) {
  return gates == 0 ? 0 : std::min(gates, gates_in_table_max) * sizeof(Entry) + alignof(Entry) - 1;
}

std::size_t bytes_with_gate_table(std::size_t sample_bytes, std::size_t gates) {
  return gates == 0 ? sample_bytes : gate_table_begin(sample_bytes) + gates * sizeof(Entry);
}

void write_gate_table(SampleBuffer& sample, std::size_t slots, std::span<const std::shared_ptr<Gate>> gates) {
  const std::size_t begin = gate_table_begin(sample_bytes(sample, slots));
  std::size_t at = begin;
  std::uint16_t written = 0;
  for (const std::shared_ptr<Gate>& gate : gates) {
    if (!gate->passes() || written == gates_in_table_max) continue;
    if (at + sizeof(Entry) > sample.capacity) break;
    const Entry entry{gate->id(), gate->ordinal()};
    std::memcpy(sample.data + at, &entry, sizeof entry);
    at += sizeof entry;
    ++written;
  }
  // An atomic store, because the agent's thread may already be sending this sample to a late reader.
  __atomic_store_n(&sample.header().gates, written, __ATOMIC_RELEASE);
}

std::optional<std::uint32_t> ordinal_in_gate(const SampleBuffer& sample, std::size_t slots,
                                             std::uint64_t gate) {
  const std::size_t gates = __atomic_load_n(&sample.header().gates, __ATOMIC_ACQUIRE);
  if (gates == 0 || gates > gates_in_table_max) return {};
  const std::size_t bytes = sample_bytes(sample, slots);
  if (bytes_with_gate_table(bytes, gates) > sample.capacity) return {};
  const std::byte* at = sample.data + gate_table_begin(bytes);
  std::optional<std::uint32_t> ordinal;
  for (std::size_t i = 0; i < gates; ++i, at += sizeof(Entry)) {
    Entry entry;
    std::memcpy(&entry, at, sizeof entry);
    if (entry.gate != gate) continue;
    if (ordinal) return {};  // two gates have this hash, so the number is ambiguous
    ordinal = entry.ordinal;
  }
  return ordinal;
}

}  // namespace sft::core
