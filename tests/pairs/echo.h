// Receives the messages that nodes write on the control topics, and writes all of them again. Networks and
// caches may also repeat old messages, though not so many.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/discovery/discovery.h"

namespace sft::test {

class Echo final : private core::DiscoveryListener {
 public:
  Echo();

  /// Repeats all announcements and requests that have arrived so far, the oldest last. Then writes an
  /// announcement and the second request of a reader named "echo", which show other nodes that they have
  /// received all repeated messages.
  void repeat();

 private:
  void endpoint_seen(const core::Endpoint& endpoint) override { endpoints_.push_back(endpoint); }
  void endpoint_departed(core::EndpointId) override {}
  void endpoint_lost(core::EndpointId) override {}
  void request_received(const core::Request& request) override { requests_.push_back(request); }
  void report_received(const core::NodeReport&) override {}
  void log_news(News, const std::string&, std::uint64_t) override {}

  std::vector<core::Endpoint> endpoints_;
  std::vector<core::Request> requests_;
  std::unique_ptr<core::Discovery> discovery_;
};

}  // namespace sft::test
