// Parts of fields that are read at their place in a larger sample, of which other readers read other parts.
// The reader's own sample has all other fields, rewritten for the parts, and empty fields in place of the
// parts. Views find the parts through this class.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "sft/detail/cut.h"
#include "sft/detail/layout.h"
#include "sft/detail/walk.h"

namespace sft::detail {

/// A part in the larger sample.
struct PartInPlace {
  const SampleState* source = nullptr;
  Layout::Field data{};
  const Cut* cut = nullptr;  ///< the places of its cells

  /// Returns the bytes of the part in the larger sample if they are contiguous. Returns nothing if they are
  /// not contiguous, or if the bytes of the larger sample are malformed.
  std::optional<std::span<const std::byte>> contiguous() const noexcept;
  /// Copies the cells of the part to `to`, cut->bytes() bytes. Must not be called for a part that is the
  /// whole field, which is contiguous.
  void gather_to(std::byte* to) const noexcept;
};

class PartsInPlace {
 public:
  /// Returns the part of that leaf; nothing if the sample itself has the field. Any thread may call this.
  virtual std::optional<PartInPlace> find(std::size_t leaf) noexcept = 0;
  /// Returns the bytes of the part in contiguous memory: in the larger sample, or in a copy that the first
  /// call makes. Returns nothing if the sample itself has the field. Returns an empty span if there is no
  /// memory for the copy. Any thread may call this. The result is valid as long as the sample.
  virtual std::optional<std::span<const std::byte>> bytes_of(std::size_t leaf) noexcept = 0;
  /// Returns the sample with its parts, which the first call puts together. The returned sample has no body
  /// if there is too little memory, or if the bytes are malformed. Any thread may call this. The result is
  /// valid as long as the sample.
  virtual const SampleState& put_together() noexcept = 0;

 protected:
  ~PartsInPlace() = default;
};

}  // namespace sft::detail
