#include "shm_transport/host/sample_check.h"

#include <cstring>

#include "core/seam/gate_table.h"

namespace sft::shm {

std::optional<CheckedSample> check_sample(const std::byte* data, std::size_t size, const TypeSupport& type,
                                          core::EndpointId writer) noexcept {
  const std::size_t body_offset = detail::SampleLayout(type.index_slots()).body_offset;
  if (size < body_offset) return std::nullopt;
  // A copy of the header, because the writer could change the header in the chunk after the check. The
  // empty instruction keeps the compiler from reading the chunk in place of the copy.
  detail::SampleHeader header;
  std::memcpy(&header, data, sizeof header);
  asm("" : "+m"(header));
  const bool ours = header.magic == detail::sample_magic && header.index_slots == type.index_slots() &&
                    header.type_hash == type.hash() && header.writer == writer &&
                    header.body_offset == body_offset;
  if (!ours || header.body_bytes > size - body_offset) return std::nullopt;

  const auto* index = reinterpret_cast<const std::uint32_t*>(data + sizeof(detail::SampleHeader));
  for (std::size_t slot = 0; slot < type.index_slots(); ++slot) {
    const std::uint32_t offset = __atomic_load_n(index + slot, __ATOMIC_RELAXED);
    if (offset >= header.body_bytes && offset != detail::no_offset) return std::nullopt;
  }
  CheckedSample checked{.bytes = body_offset + header.body_bytes};
  const std::size_t with_table = core::bytes_with_gate_table(checked.bytes, header.gates);
  if (header.gates <= core::gates_in_table_max && with_table <= size) checked.bytes = with_table;
  checked.origin.trust(header);
  return checked;
}

}  // namespace sft::shm
