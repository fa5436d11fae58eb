// The message types that tests run over.
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
  /// "sensor_msgs_msg_Image": letters that a test's name may have.
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

/// Every type that is generated for sft_every_type, each once, by header. contestants.py makes the list.
std::vector<MessageType> generated_types();

/// PointCloud2, LaserScan, BatteryState, Image, OccupancyGrid, Odometry.
std::span<const MessageType> common_types();

/// All types above, and some that are made to be difficult (tests/generators/idl/torture.idl,
/// tests/unit/typesupport/proof.idl) or have layout rules (layouts.idl there). The order is kept: inputs of
/// the fuzzer name types by their number.
std::span<const MessageType> all_types();

/// all_types(), and behind them all other types of the tests and the common packages, by name. Only for
/// programs that link to sft_every_type.
std::span<const MessageType> every_type();

}  // namespace sft::test
