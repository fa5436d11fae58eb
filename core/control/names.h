// Names of nodes, topics and types: what they may be, and how they are quoted to people. Whatever reaches a
// log or a terminal in a name has passed these.
#pragma once

#include <string>
#include <string_view>

#include "sft/typesupport/result.h"

namespace sft::core {

/// Why this cannot be a name: empty, more than 255 bytes, no UTF-8, or control characters in it; empty if it
/// can be one. For a node the empty name will do.
std::string_view fault_of_name(std::string_view name);
/// The same of a topic, which has no empty parts between slashes, no blank at either end and no '~' either.
std::string_view fault_of_topic(std::string_view topic);

/// Within quotation marks, cut where it is long, and with escapes for what is no text.
std::string in_quotes(std::string_view text);

/// A topic as it is compared, announced and shown: "/points" and "points" are one. Refers to `topic`.
std::string_view without_slash(std::string_view topic);

}  // namespace sft::core
