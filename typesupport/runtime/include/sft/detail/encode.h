// Encodes the owned struct as CDR under a mask.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sft/detail/loan_view.h"
#include "sft/detail/postponed_copies.h"
#include "sft/detail/type_table.h"
#include "sft/mask.h"

namespace sft::detail {

enum class EncodeStatus : std::uint8_t {
  ok,
  too_large,       ///< the body has 4 GiB or more, or a string or sequence exceeds its bound
  string_has_nul,  ///< a string contains NUL, which ends it in CDR
  bad_boolean,     ///< a byte in an array or a sequence of booleans is neither 0 nor 1
};
const char* to_string(EncodeStatus status);

struct EncodedSize {
  EncodeStatus status = EncodeStatus::ok;
  std::uint32_t bytes = 0;
};

/// Returns the size of the body that encode() will write for the same arguments. `mask` must be closed
/// (TypeSupport::closed).
EncodedSize encoded_size(const StructType& type, const void* value, const FieldMask& mask,
                         std::span<const Reservation> reservations = {}) noexcept;

/// Writes the body of the type projected to `mask` to `body` (8-aligned, exactly encoded_size() bytes), and
/// the offset of every slot to `index` (slot_count(type) entries; no_offset if absent). Padding is zero.
/// The elements of reserved sequences are left as they are, and the reserved length is written as their
/// length. `postponed` must be empty; long runs are added to it and not written to `body`. If `postponed`
/// is null, everything is written.
void encode(const StructType& type, const void* value, const FieldMask& mask, std::span<std::byte> body,
            std::span<std::uint32_t> index, std::span<const Reservation> reservations = {},
            PostponedCopies* postponed = nullptr) noexcept;

}  // namespace sft::detail
