// Parts of fields that stay where they are: in a larger sample, of which other readers read other parts. The
// sample that a reader gets has all other fields, rewritten for the parts, and empty fields where the parts
// belong. Views find the parts here.
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
  const Cut* cut = nullptr;  ///< where its cells lie

  /// All bytes, where they are if they lie one behind the other there. Nothing if they do not, or if they are
  /// not what they claim to be.
  std::optional<std::span<const std::byte>> contiguous() const noexcept;
  /// Copies cut->bytes() one behind the other. Not of a part that is the whole field, which is contiguous.
  void gather_to(std::byte* to) const noexcept;
};

class PartsInPlace {
 public:
  /// The part of that leaf; nothing if the sample itself has the field. Any thread.
  virtual std::optional<PartInPlace> find(std::size_t leaf) noexcept = 0;
  /// Its bytes, one behind the other: in the larger sample, or in a copy that the first call makes. Nothing
  /// if the sample itself has the field. Empty without memory. Any thread; valid as long as the sample.
  virtual std::optional<std::span<const std::byte>> bytes_of(std::size_t leaf) noexcept = 0;
  /// The sample with its parts, which the first call puts together. Empty without memory, or if its bytes are
  /// not what they claim to be. Any thread; valid as long as the sample.
  virtual const SampleState& put_together() noexcept = 0;

 protected:
  ~PartsInPlace() = default;
};

}  // namespace sft::detail
