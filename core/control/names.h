// Checks names of nodes, topics and types. A name is written to a log or a terminal only if it has passed
// these checks or in_quotes().
//
// Each function returns the reason why a text is no such name, or an empty text if it is one.
#pragma once

#include <string_view>

#include "core/platform/quotes.h"

namespace sft::core {

/// Any name, as another process announces it: it has up to name_bytes_max bytes of UTF-8, and no control
/// characters.
std::string_view fault_of_name(std::string_view name);
/// The same for a topic, which also must not have empty parts between slashes, a blank at either end, or a
/// '~'.
std::string_view fault_of_announced_topic(std::string_view topic);

// Names that a program of this process gives follow the rules by which ROS 2 checks names (rmw): they consist
// of ASCII letters, digits and '_', and no part between slashes begins with a digit.

/// Checks the name of a topic or a service, with or without a slash in front.
std::string_view fault_of_topic(std::string_view topic);
/// A namespace, with or without a slash in front; it may be empty, or the slash alone.
std::string_view fault_of_namespace(std::string_view name);
/// A node without its namespace.
std::string_view fault_of_node(std::string_view name);

/// Returns a topic as it is compared, announced and shown, since "/points" and "points" are the same. The
/// result refers to `topic`.
std::string_view without_slash(std::string_view topic);

}  // namespace sft::core
