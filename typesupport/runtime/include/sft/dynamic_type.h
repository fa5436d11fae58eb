// A message type that is not compiled into the program. Node::find_type() makes it from the description
// that is announced with a topic. from_msg() (msg_text.h) makes it from the text of a .msg file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "sft/result.h"
#include "sft/type.h"
#include "sft/type_support.h"

namespace sft {

/// A handle of a type. Copies of the handle share the type, which keeps its address and lives as long as any
/// copy. The type is immutable, and any thread may use it. Its members have no offset, stride and access
/// (type.h).
class DynamicType {
 public:
  /// Limits for a description or a text. `leaves` and the limits after it count a struct as often as it is
  /// used.
  struct Limits {
    std::size_t bytes = 65'536;               ///< the maximum length of the description
    std::size_t name_bytes = 255;             ///< the maximum length of each name and unit
    std::uint32_t array_elements = 1U << 28;  ///< the maximum length of each array, over all its dimensions
    std::size_t depth = 32;                   ///< the maximum nesting of structs; real types: up to 25
    /// The maximum number of leaves, which is the maximum that a request can name.
    std::size_t leaves = 4096;
    std::size_t members = 32'768;      ///< the maximum number of members and enumerators together
    std::size_t path_bytes = 1 << 20;  ///< the approximate maximum for the paths of all leaves
  };

  /// Reads a description (type_description.md). The bytes may be hostile: the time and the memory for
  /// reading are proportional to the number of bytes. The error names the refused part.
  static Result<DynamicType> parse(std::span<const std::byte> description, const Limits& limits);
  // There are two overloads, because a default argument cannot use the default member values of Limits:
  // they are known only after DynamicType.
  /// Parses within the usual limits.
  static Result<DynamicType> parse(std::span<const std::byte> description) {
    return parse(description, Limits());
  }

  /// Returns the name in the IDL: "sensor_msgs::msg::Imu".
  std::string_view name() const { return type().name; }
  /// Returns the tables of the type. They are valid as long as any handle of the type.
  const StructType& type() const;
  /// Returns the hash, which equals TypeSupport::hash() of the compiled type.
  std::uint64_t hash() const;
  /// Returns the object that reads and prints masks of the type. The first call makes the object, which all
  /// copies share.
  const TypeSupport& support() const;
  /// Returns the bytes from which the type was read. They are valid as long as the type.
  std::span<const std::byte> description() const;

 private:
  class Storage;
  class Parser;
  explicit DynamicType(std::shared_ptr<const Storage> storage) : storage_(std::move(storage)) {}

  std::shared_ptr<const Storage> storage_;
};

}  // namespace sft
