// A message type that was not compiled in but read from its description. Everything that works from a
// StructType or a TypeSupport works with it, except for what needs an owned C++ struct (encoded_size, encode,
// decode): its members have no offsets, strides and access.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "sft/typesupport/result.h"
#include "sft/typesupport/type_description.h"
#include "sft/typesupport/type_support.h"

namespace sft {

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
