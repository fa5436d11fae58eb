// Names of nodes, topics and types: what they may be. Whatever reaches a log or a terminal in a name has
// passed these, or in_quotes().
#pragma once

#include <string_view>

#include "core/platform/quotes.h"

namespace sft::core {

/// Returns the reason why this text cannot be a name: it is empty, has more than name_bytes_max bytes, is not
/// UTF-8, or contains control characters. Returns an empty text if it can be one. A node may have the empty
/// name.
std::string_view fault_of_name(std::string_view name);
/// The same of a topic, which has no empty parts between slashes, no blank at either end and no '~' either.
std::string_view fault_of_topic(std::string_view topic);

/// A topic as it is compared, announced and shown: "/points" and "points" are one. Refers to `topic`.
std::string_view without_slash(std::string_view topic);

}  // namespace sft::core
