// The message types that tests run over.
#pragma once

#include <iosfwd>
#include <span>
#include <string>

#include "sft/typesupport/type_support.h"
#include "tests/support/owned_value.h"

namespace sft::test {

struct MessageType {
  const TypeSupport* support;
  OwnedValue (*make)();

  const StructType& type() const { return support->type(); }
  std::string short_name() const {
    return std::string(support->name().substr(support->name().rfind(':') + 1));
  }
};

template <class T>
MessageType message_type() {
  static const TypeSupport support(TypeTable<T>::type);
  return {&support, &OwnedValue::of<T>};
}

/// PointCloud2, LaserScan, BatteryState, Image, OccupancyGrid, Odometry.
std::span<const MessageType> common_types();

/// Those, and types made to be difficult (tests/idl/torture.idl, tests/typesupport/proof.idl). The order is
/// kept: inputs of the fuzzer name types by their number.
std::span<const MessageType> all_types();

void PrintTo(const MessageType& type, std::ostream* out);

}  // namespace sft::test
