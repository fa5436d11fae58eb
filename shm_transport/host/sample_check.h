// Checks that a chunk from another process is a sample that every getter can read safely.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/seam/transport.h"
#include "sft/type_support.h"

namespace sft::shm {

/// The properties of a sample at the moment of its check. The header in the chunk may change later.
struct CheckedSample {
  /// Size of header, index and body in bytes. Readers must not read beyond this size, whatever the header
  /// in the chunk says later.
  std::size_t bytes = 0;
  core::SampleOrigin origin{};
};

/// Checks the chunk. Returns nothing if it is no valid sample of this type and writer. Reads the header
/// once and the index once, and does not read the body. `data` must be aligned to 8 bytes, and `size` bytes
/// must be mapped.
std::optional<CheckedSample> check_sample(const std::byte* data, std::size_t size, const TypeSupport& type,
                                          core::EndpointId writer) noexcept;

}  // namespace sft::shm
