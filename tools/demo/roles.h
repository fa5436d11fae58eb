// The roles of the demo, each in its own process: a lidar that publishes clouds, and five subscribers that
// read the fields that they need. A role answers each message of the demo with its report, until the
// channel closes.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "sft/node.h"
#include "tools/demo/channel.h"

namespace sft::demo {

struct RunOptions {
  double hz = 10;
  std::uint64_t samples = 0;
  bool is_recorded = false;  ///< true: subscribers record their fields, and declare none
};

struct RolePlan {
  std::string name;
  std::uint32_t domain = 0;
  TransportChoice transport = TransportChoice::automatic;
  /// The interface whose traffic is measured; empty: no traffic is measured
  std::optional<std::string> interface {};
  double max_rate_hz = 0;  ///< the maximum rate of a subscriber; 0: all clouds
  RunOptions options{};
};

/// Publishes clouds after the message "begin", until the last sample or the message "end".
void run_publisher(const RolePlan& plan, Channel& channel);

struct SubscriberRole {
  const char* name;
  const char* host;
  const char* purpose;
  double max_rate_hz;
  void (*run)(const RolePlan& plan, Channel& channel);
};
extern const std::array<SubscriberRole, 5> subscriber_roles;  ///< the last one is on the publisher's host

}  // namespace sft::demo
