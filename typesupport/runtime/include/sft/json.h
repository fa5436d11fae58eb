// Samples as JSON, for other programs, and messages from JSON. What JSON has no word for:
//
//   NaN and infinities             the strings "NaN", "Infinity", "-Infinity"
//   64-bit integers                numbers, all digits (parsers that use doubles lose some beyond 2^53)
//   float                          the shortest number that is this float, 0.1 and not 0.10000000149011612
//   char                           a string of one character
//   octet and uint8 collections    base64 in a string (RFC 4648, padded), or numbers by option
//   text that is not UTF-8         U+FFFD for each part that is not
//   enumerations                   the name; the number where it has none
//   an absent field                is left out; if of a sequence of structs only the length was sent, it is
//                                  "fields.size": 2
//   elements beyond the limit      the last element is the string "... 997 more"
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

/// Form and limits of a message as JSON.
struct JsonOptions {
  int indent = -1;                      ///< spaces per level; -1: one line
  std::size_t elements_max = SIZE_MAX;  ///< of each array and sequence, but not of those in base64
  /// Sequences and arrays of octets and uint8 as one string in base64; else as numbers.
  bool bytes_as_base64 = true;
  std::size_t output_bytes_max = 64 * 1024 * 1024;  ///< about; more is an error
};

/// `view` is a whole sample or any part of it that is there. An error if the bytes are not what they claim to
/// be.
Result<std::string> to_json(const DynamicView& view, const JsonOptions& options = {});

/// Limits and special words for reading messages as JSON.
struct FromJsonOptions {
  std::size_t bytes_max = 64 * 1024 * 1024;  ///< of the body; more is an error
  /// What "now" stands for in the place of a builtin_interfaces/Time, and "auto" in the place of a
  /// std_msgs/Header, whose other members are then zero or empty. Nothing: these words mean nothing.
  std::optional<std::chrono::sys_time<std::chrono::nanoseconds>> now{};
};

/// The other way: a whole message of `type` as publish_cdr() takes it, 4 bytes of encapsulation and a body.
/// The text is as to_json() writes it, in any order; bytes may be base64 or numbers. Members that are left
/// out are zero or empty; those that the type does not have are an error. Errors name the path of the field
/// and what was expected: "'fields[1].offset' is -1; an integer from 0 to 4294967295 was expected". The text
/// may be hostile.
Result<std::vector<std::byte>> cdr_from_json(const StructType& type, std::string_view json,
                                             const FromJsonOptions& options = {});

}  // namespace sft
