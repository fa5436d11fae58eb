#include <memory>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <string>

#include "bench/common/contest.h"
#include "bench/selection/selection.h"
#include "core/seam/gate.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::BatteryState;

constexpr double bound_ns = 30;  ///< the bound of the time per gate and sample

/// Returns a gate that has evaluated the message once, and does not let it pass again.
std::unique_ptr<core::Gate> closed_gate(const std::string& conditions, const BatteryState& message) {
  const TypeSupport& type = type_support<BatteryState>();
  const Selection selection = type.parse_selection("* @ " + conditions).value();
  auto gate = std::make_unique<core::Gate>(0, detail::Conditions(type.type(), selection.gate().conditions),
                                           selection.gate_hash());
  gate->reader_begins();
  gate->consider(detail::FieldSource::of_message(&message), 0);
  gate->made(detail::FieldSource::of_message(&message), 0);
  return gate;
}

Figure time_of(std::string name, const std::string& conditions, int rounds) {
  BatteryState message;
  message.voltage = 11.1F;
  message.percentage = 0.5F;
  const auto gate = closed_gate(conditions, message);
  const auto best = best_times_ns(
      {batch_of([&] { gate->consider(detail::FieldSource::of_message(&message), 1); })}, rounds);
  return {std::move(name), best[0], "ns", bound_ns, "the bound, for " + conditions, 1.0};
}

}  // namespace

std::vector<Figure> closed_gates(int rounds) {
  return {time_of("gate_closed", "voltage > 20", rounds),
          time_of("gate_closed_changed", "changed(voltage) 1 %", rounds),
          time_of("gate_closed_several", "changed(voltage, current, percentage) 1 % or every 10 s", rounds)};
}

}  // namespace sft::bench
