// Whether a chunk that another process wrote is a sample that every getter can read safely.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/seam/transport.h"
#include "sft/type_support.h"

namespace sft::shm {

/// What the header said when it was checked, which it may no longer do.
struct CheckedSample {
  std::size_t bytes =
      0;  ///< header, index and body: what may be read, from now on and whatever the header says
  core::EndpointId writer = 0;
  std::uint64_t sequence = 0;
  std::int64_t source_stamp_ns = 0;
  std::uint64_t diverted_sequence = 0;
  std::int64_t diverted_stamp_ns = 0;
};

/// Reads the header once and the index once; the body not at all. `data` is 8-aligned, `size` bytes are
/// mapped.
std::optional<CheckedSample> check_sample(const std::byte* data, std::size_t size, const TypeSupport& type,
                                          core::EndpointId writer) noexcept;

}  // namespace sft::shm
