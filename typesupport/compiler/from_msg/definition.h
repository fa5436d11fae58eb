// The content of one .msg file, or of a part of a .srv file. Names and values have been checked. Of nested
// types, only the names are known.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "model.h"

namespace sft::msg {

/// The name of a message type, "geometry_msgs/msg/Point"; empty for other types.
struct TypeName {
  std::string package;
  std::string name;
  std::string folder = "msg";  ///< the folder of the type; "srv" for a part of a service

  std::string text() const { return package + "/" + folder + "/" + name; }
  auto operator<=>(const TypeName&) const = default;
};

/// The type of a field or a constant: a single value, an array of one dimension, or a sequence.
struct Type {
  sft_kind kind = SFT_BOOLEAN;     ///< the kind of one element
  TypeName nested;                 ///< the element's type if kind is SFT_STRUCTURE
  std::uint32_t string_bound = 0;  ///< the maximum length of each string in bytes; 0: unbounded
  std::uint32_t array_size = 0;    ///< length of the array; 0: the type is no array
  bool is_sequence = false;
  std::uint32_t bound = 0;  ///< the maximum number of elements of a sequence; 0: unbounded

  bool is_single() const { return array_size == 0 && !is_sequence; }
  bool operator==(const Type&) const = default;
};

/// A value of a field or constant: std::int64_t for int8 to int64, std::uint64_t for byte, char and uint8
/// to uint64, and double for both floats.
using Value = std::variant<bool, std::int64_t, std::uint64_t, double, std::string>;

struct Constant {
  Type type;
  std::string name;
  Value value;
  std::uint32_t line;

  bool operator==(const Constant&) const = default;
};

/// A layout rule in the spelling of the file.
struct Layout {
  std::string text;          ///< text of the rule; empty: no rule is given
  std::uint32_t line = 0;    ///< the line in which the text begins
  std::uint32_t column = 0;  ///< the column in which the text begins, from 1

  bool operator==(const Layout&) const = default;
};

struct Field {
  Type type;
  std::string name;
  std::vector<Value> initial;  ///< the default: one value, or one per element; empty: no default is given
  std::string unit;            ///< unit of the field, such as "m/s"; empty: no unit is given
  std::uint32_t line;
  Layout layout{};

  bool operator==(const Field&) const = default;
};

struct Definition {
  TypeName type;
  std::vector<Constant> constants;
  std::vector<Field> fields;  ///< the fields, of which there is at least one

  bool operator==(const Definition&) const = default;
};

/// An error in a definition.
struct Problem {
  std::uint32_t line;
  /// The name of the field or constant. Empty: the error concerns the line or the whole message.
  std::string member;
  std::string text;          ///< a text that says what is wrong, and what to do
  std::uint32_t column = 0;  ///< the column, from 1; 0: the error concerns the whole line
};

}  // namespace sft::msg
