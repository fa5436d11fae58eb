// Parses the text of a .msg file, or of a part of a .srv file, in ROS 2's syntax (msg.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "from_msg/definition.h"

namespace sft::msg {

/// Limits of a text. Within them, parsing takes at most a second and 64 MiB.
struct Limits {
  static constexpr std::size_t bytes = 1 << 20;
  static constexpr std::size_t members = 4096;  ///< the maximum number of fields and constants together
  static constexpr std::size_t problems = 100;  ///< parsing ends after this number of reports
  static constexpr std::size_t levels = 256;    ///< the maximum nesting of messages
};

/// Parses the text. Returns the definition of the type `name`, or its errors in the order of lines. The
/// result depends on the arguments only, and does not refer to them. `lines_before` lines precede the text
/// in the same file.
tl::expected<Definition, std::vector<Problem>> parse(std::string_view text, const TypeName& name,
                                                     std::uint32_t lines_before = 0);

}  // namespace sft::msg
