// Receives the messages that nodes write on the control topics, and writes all of them again. Networks and
// caches may also repeat old messages, though not so many.
#pragma once

#include <memory>
#include <mutex>
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
  void endpoint_seen(core::Endpoint endpoint) override;
  void endpoint_departed(core::EndpointId) override {}
  void endpoint_lost(core::EndpointId) override {}
  void request_received(core::Request request) override;
  void report_received(core::NodeReport) override {}
  void log_news(News, std::string) override {}

  std::mutex mutex_;
  std::vector<core::Endpoint> endpoints_;
  std::vector<core::Request> requests_;
  std::unique_ptr<core::Discovery> discovery_;
};

}  // namespace sft::test
