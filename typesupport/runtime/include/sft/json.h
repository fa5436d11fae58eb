// Samples as JSON for other programs, and messages from JSON. JSON cannot express some values. They are
// written like this:
//
//   NaN and infinities             the strings "NaN", "Infinity", "-Infinity"
//   64-bit integers                numbers, all digits (parsers that use doubles lose some beyond 2^53)
//   float                          the shortest number that is this float, 0.1 and not 0.10000000149011612
//   char                           a string of one character
//   octet and uint8 collections    base64 in a string (RFC 4648, padded), or numbers by option
//   text that is not UTF-8         U+FFFD for each invalid part
//   enumerations                   the name; the number if the value has no name
//   an absent field                is left out; a sequence of structs of which only the length was sent is
//                                  "fields.size": 2
//   elements beyond the limit      the last element is the string "... 997 more"
//
// All functions are pure; any thread may call them. They allocate memory.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sft/dynamic_view.h"
#include "sft/result.h"

namespace sft {

/// Options for writing JSON.
struct JsonOptions {
  int indent = -1;  ///< number of spaces per level; -1: one line
  /// The maximum number of elements that are written of each array and sequence, except in base64.
  std::size_t elements_max = SIZE_MAX;
  bool bytes_as_base64 = true;  ///< false: bytes are written as numbers
  /// The approximate maximum size of the output in bytes; a longer output is an error.
  std::size_t output_bytes_max = 64 * 1024 * 1024;
};

/// Writes a whole sample, or any part of it that is present. Returns an error if the bytes are malformed.
Result<std::string> to_json(const DynamicView& view, const JsonOptions& options = {});

/// Options for reading JSON.
struct FromJsonOptions {
  std::size_t bytes_max = 64 * 1024 * 1024;  ///< the maximum size of the body
  /// The time for the words "now" and "auto". "now" may stand in the place of a builtin_interfaces/Time.
  /// "auto" may stand in the place of a std_msgs/Header, whose other members are then zero or empty. If
  /// `now` is not set, these words are errors.
  std::optional<std::chrono::sys_time<std::chrono::nanoseconds>> now{};
};

/// Reads a whole message of `type`, and encodes it for publish_cdr(): 4 bytes of encapsulation and a body.
/// The text has the form that to_json() writes, except that members may be in any order and that bytes may
/// be base64 or numbers. Members that are left out are zero or empty. Members that the type does not have
/// are an error. Errors name the path of the field and the expected value: "'fields[1].offset' is -1; an
/// integer from 0 to 4294967295 was expected". The text may be hostile.
Result<std::vector<std::byte>> cdr_from_json(const StructType& type, std::string_view json,
                                             const FromJsonOptions& options = {});

}  // namespace sft
