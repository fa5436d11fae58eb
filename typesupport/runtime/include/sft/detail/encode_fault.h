// Explains in a sentence why a value cannot be encoded. encoded_size() only reports the failure, which
// costs nothing extra. encode_fault() visits the value again and allocates memory, so it is called only
// after a failure.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "sft/detail/loan_view.h"
#include "sft/mask.h"
#include "sft/type_support.h"

namespace sft::detail {

/// Returns a text that names the field that exceeds its bound, has a NUL or is no boolean, with its size
/// and the limit: "'tags[1]' has 9 characters; its bound is 8". If the body would have more than
/// `bytes_max` bytes, the text names the field that takes the most of them. Empty if nothing is wrong.
/// `type` is the type of the message. The other arguments are those of encoded_size().
std::string encode_fault(const TypeSupport& type, const Message& message, const FieldMask& mask,
                         std::size_t bytes_max, std::span<const Reservation> reservations = {});

}  // namespace sft::detail
