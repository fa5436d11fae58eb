// Hears what nodes say on the control topics and says it all once more: what networks and caches do with old
// messages, only worse.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "core/discovery/discovery.h"

namespace sft::test {

class Echo final : private core::DiscoveryListener {
 public:
  Echo();

  /// All announcements and requests that came so far, the oldest last; and behind them the announcement and
  /// the second request of a reader called "echo", so that others can tell when they have heard them.
  void repeat();

 private:
  void endpoint_seen(core::Endpoint endpoint) override;
  void endpoint_departed(core::EndpointId) override {}
  void endpoint_lost(core::EndpointId) override {}
  void request_received(core::Request request) override;
  void liveliness_asserted(core::Assertion) override {}
  void control_malformed(std::string) override {}

  std::mutex mutex_;
  std::vector<core::Endpoint> endpoints_;
  std::vector<core::Request> requests_;
  std::unique_ptr<core::Discovery> discovery_;
};

}  // namespace sft::test
