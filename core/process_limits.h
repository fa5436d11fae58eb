// Whether the limits of the process leave room for what is about to be opened. Cyclone DDS ends the process
// where they do not, and elsewhere the error would name a symptom.
#pragma once

#include <cstddef>

#include "sft/typesupport/result.h"

namespace sft::core {

/// Errc::limit_exceeded says which limit it is, and how to raise it. Takes so many file descriptors, and
/// starts so many threads unless all limits are far, and gives them back.
Result<void> check_room_for(std::size_t descriptors, std::size_t threads);

}  // namespace sft::core
