// Reads the text of a .msg file, with the syntax that ROS 2 gives it (msg.md).
#pragma once

#include <cstddef>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "from_msg/definition.h"

namespace sft::msg {

/// What a text may have at most, so that no text takes more than moments and a few times its size in memory.
struct Limits {
  static constexpr std::size_t bytes = 1 << 20;
  static constexpr std::size_t members = 4096;  ///< fields and constants together
  static constexpr std::size_t problems = 100;  ///< that are reported
  static constexpr std::size_t levels = 256;    ///< of nested messages
};

/// The definition of the type `name`, or all that is wrong with it, at least one problem, in the order of
/// lines. The result depends on nothing but the arguments and refers to none of them.
tl::expected<Definition, std::vector<Problem>> parse(std::string_view text, const TypeName& name);

}  // namespace sft::msg
