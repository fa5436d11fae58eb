// Names of nodes, topics and types: what they may be. Whatever reaches a log or a terminal in a name has
// passed these, or in_quotes().
//
// Each function returns the reason why a text is no such name; an empty text if it is one.
#pragma once

#include <string_view>

#include "core/platform/quotes.h"

namespace sft::core {

/// Any name, as another process announces it: it has up to name_bytes_max bytes of UTF-8, and no control
/// characters.
std::string_view fault_of_name(std::string_view name);
/// The same of a topic, which has no empty parts between slashes, no blank at either end and no '~' either.
std::string_view fault_of_announced_topic(std::string_view topic);

// What a program of this process names follows the rules by which ROS 2 checks names (rmw): letters of ASCII,
// digits and '_', of which no part between slashes begins with a digit.

/// A topic or a service, with or without a slash in front.
std::string_view fault_of_topic(std::string_view topic);
/// A namespace, with or without a slash in front; it may be empty, or the slash alone.
std::string_view fault_of_namespace(std::string_view name);
/// A node without its namespace.
std::string_view fault_of_node(std::string_view name);

/// A topic as it is compared, announced and shown: "/points" and "points" are one. Refers to `topic`.
std::string_view without_slash(std::string_view topic);

}  // namespace sft::core
