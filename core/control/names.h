// Checks names of nodes, topics and types. A name is written to a log or a terminal only if it has passed
// these checks or in_quotes().
#pragma once

#include <string_view>

#include "core/platform/quotes.h"

namespace sft::core {

/// Returns the reason why this text cannot be a name: it is empty, has more than name_bytes_max bytes, is not
/// UTF-8, or contains control characters. Returns an empty text if it can be one. A node may have the empty
/// name.
std::string_view fault_of_name(std::string_view name);
/// The same for a topic, which also must not have empty parts between slashes, a blank at either end, or a
/// '~'.
std::string_view fault_of_topic(std::string_view topic);

/// Returns a topic as it is compared, announced and shown, since "/points" and "points" are the same. The
/// result refers to `topic`.
std::string_view without_slash(std::string_view topic);

}  // namespace sft::core
