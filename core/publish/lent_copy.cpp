#include "core/publish/lent_copy.h"

#include <cstring>

#include "sft/detail/sample_format.h"

namespace sft::core {

SampleHandle copy_into(LendingWriter& memory, const SampleBuffer& sample, const TypeSupport& type,
                       std::size_t more_bytes) noexcept {
  if (!sample.mask.is_full()) return {};
  // The sample may also lie in the shared memory of a former port, where its header must not be trusted.
  const std::size_t bytes =
      detail::SampleLayout(type.index_slots()).bytes(state_of(sample, type.index_slots()).body_bytes);
  SampleHandle copy = memory.loan(bytes + more_bytes);
  if (!copy) return {};
  std::memcpy(copy->data, sample.data, bytes);
  copy->header().gates = 0;
  copy->mask = sample.mask;
  copy->whole_bytes = sample.whole_bytes;
  copy->trust_header();
  return copy;
}

}  // namespace sft::core
