// Checks that a chunk that another process wrote is a sample that every getter can read safely.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/seam/transport.h"
#include "sft/type_support.h"

namespace sft::shm {

/// A sample at the moment of the check. The header in the chunk may change later.
struct CheckedSample {
  /// Bytes of header, index and body. Readers stay within them, whatever the header says later.
  std::size_t bytes = 0;
  core::SampleOrigin origin{};
};

/// Returns nothing if the chunk is no valid sample of this type and writer. Reads the header once and the
/// index once, and does not read the body. `data` is aligned to 8 bytes, and `size` bytes are mapped.
std::optional<CheckedSample> check_sample(const std::byte* data, std::size_t size, const TypeSupport& type,
                                          core::EndpointId writer) noexcept;

}  // namespace sft::shm
