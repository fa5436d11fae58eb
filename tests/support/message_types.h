// Lists of message types for tests that run once for each type.
#pragma once

#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "sft/type_support.h"
#include "tests/support/owned_value.h"

namespace sft::test {

struct MessageType {
  const TypeSupport* support;
  OwnedValue (*make)();

  const StructType& type() const { return support->type(); }
  std::string short_name() const {
    return std::string(support->name().substr(support->name().rfind(':') + 1));
  }
  /// Returns a name that consists of letters which GoogleTest allows in names of tests, such as
  /// "sensor_msgs_msg_Image".
  std::string test_name() const {
    std::string result;
    for (const char c : support->name()) {
      if (c != ':') result += c;
      if (c == ':' && result.back() != '_') result += '_';
    }
    return result;
  }
};

inline void PrintTo(const MessageType& type, std::ostream* out) { *out << type.support->name(); }

template <class T>
MessageType message_type() {
  static const TypeSupport support(detail::TypeTable<T>::type);
  return {&support, &OwnedValue::of<T>};
}

/// Returns every type that is generated for sft_every_type, each once, in the order of headers.
/// contestants.py generates the list.
std::vector<MessageType> generated_types();

/// Returns PointCloud2, LaserScan, BatteryState, Image, OccupancyGrid and Odometry.
std::span<const MessageType> common_types();

/// Returns common_types(), types that are difficult on purpose (tests/generators/idl/torture.idl,
/// tests/unit/typesupport/proof.idl), and types with layout rules (layouts.idl in the latter folder). The
/// order must not change, because inputs of the fuzzer refer to types by their numbers.
std::span<const MessageType> all_types();

/// Returns all_types(), followed by all other types of the tests and of the common packages, ordered by name.
/// Only for programs that link to sft_every_type.
std::span<const MessageType> every_type();

}  // namespace sft::test
