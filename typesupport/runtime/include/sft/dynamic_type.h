// A message type that was not compiled in but read from its description. Everything that works from a
// StructType or a TypeSupport works with it, except for what needs an owned C++ struct (encoded_size, encode,
// decode): its members have no offsets, strides and access.
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

/// What is accepted of a description. `leaves` and what follows it count the type expanded: every struct as
/// often as it is used.
struct DescriptionLimits {
  std::size_t bytes = 65'536;
  std::size_t name_bytes = 255;  ///< of each name and unit
  std::uint32_t array_elements = 1U << 28;
  std::size_t depth = 16;            ///< of structs in structs; real types have some 5
  std::size_t leaves = 4096;         ///< as many as a request can name
  std::size_t members = 32'768;      ///< and enumerators
  std::size_t path_bytes = 1 << 20;  ///< of the paths of all leaves, about
};

/// A handle: copies share the type, which lives, unmoved, as long as any of them. Any thread.
class DynamicType {
 public:
  /// The bytes may be hostile. Takes time and memory in proportion to them; what is refused is named.
  static Result<DynamicType> parse(std::span<const std::byte> description,
                                   const DescriptionLimits& limits = {});

  /// As in the IDL: "sensor_msgs::msg::Imu".
  std::string_view name() const { return type().name; }
  /// The tables of the type. Valid as long as any handle of it.
  const StructType& type() const;
  /// Equal to the hash of the compiled type.
  std::uint64_t hash() const;
  /// Made on first use, for all copies.
  const TypeSupport& support() const;
  /// What it was parsed from; describe(type()) gives the same.
  std::span<const std::byte> description() const;

 private:
  class Storage;
  class Parser;
  explicit DynamicType(std::shared_ptr<const Storage> storage) : storage_(std::move(storage)) {}

  std::shared_ptr<const Storage> storage_;
};

}  // namespace sft
