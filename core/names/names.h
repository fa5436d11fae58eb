// Checks names of nodes, topics and types. A name is written to a log or a terminal only if it has passed
// these checks or in_quotes().
//
// Each function of the kind fault_of_...() returns the reason why a text is not a valid name of its kind, or
// an empty text if it is valid.
#pragma once

#include <cstddef>
#include <string_view>

#include "core/platform/quotes.h"

namespace sft::core {

/// The maximum size of a name of any kind in bytes.
inline constexpr std::size_t name_bytes_max = 255;

/// Checks a name of any kind, that another process has announced. The name must have up to name_bytes_max
/// bytes of UTF-8, and no control characters.
std::string_view fault_of_name(std::string_view name);
/// Checks a topic that another process has announced. The rules of fault_of_name() apply. In addition, a
/// topic must not have empty parts between slashes, a blank at either end, or a '~'.
std::string_view fault_of_announced_topic(std::string_view topic);

// Names that the program of this process chooses must follow the rules by which ROS 2 checks names (rmw):
// they consist of ASCII letters, digits and '_', and no part between slashes begins with a digit.

/// Checks the name of a topic or a service, with or without a leading slash.
std::string_view fault_of_topic(std::string_view topic);
/// Checks a namespace, with or without a leading slash. It may be empty, or consist of the slash alone.
std::string_view fault_of_namespace(std::string_view name);
/// Checks the name of a node without its namespace.
std::string_view fault_of_node(std::string_view name);

/// Returns the topic without a leading slash. This is the form in which topics are compared, announced and
/// shown. ("/points" and "points" are the same topic.) The result refers to the characters of `topic`.
std::string_view without_slash(std::string_view topic);

}  // namespace sft::core
