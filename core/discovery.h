// The two control topics on Cyclone DDS: announces our endpoints and requests, reports everybody else's. The
// only part of the core that sees Cyclone, which is behind the .cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/control.h"
#include "sft/options.h"
#include "sft/typesupport/result.h"

namespace sft::core {

struct DiscoveryOptions {
  std::uint32_t domain = 0;
  DiscoverySettings settings;
  std::string user_config;  ///< XML texts or names of files
};

/// Told what others announced. Called on Cyclone's threads, which must not be held up: post it and return.
class DiscoveryListener {
 public:
  virtual void endpoint_seen(Endpoint endpoint) = 0;
  virtual void endpoint_departed(EndpointId id) = 0;
  /// Its node stopped answering; if it returns, the endpoint is seen again.
  virtual void endpoint_lost(EndpointId id) = 0;
  virtual void request_received(Request request) = 0;
  /// These writers live.
  virtual void liveliness_asserted(std::vector<EndpointId> writers) = 0;
  /// A control sample, or the type description in one, was refused.
  virtual void control_malformed(std::string why) = 0;

 protected:
  ~DiscoveryListener() = default;
};

class Discovery {
 public:
  /// `listener` outlives the discovery.
  static Result<std::unique_ptr<Discovery>> open(const DiscoveryOptions& options,
                                                 DiscoveryListener& listener);
  virtual ~Discovery() = default;

  /// For people.
  struct Configuration {
    std::string summary;                ///< how nodes are found
    std::vector<std::string> warnings;  ///< which of the user's settings do not hold, and why
  };
  virtual const Configuration& configuration() const = 0;

  /// Announces an endpoint of ours, or that it has changed.
  virtual Result<void> announce(const Endpoint& endpoint) = 0;
  virtual void withdraw(EndpointId id) = 0;
  virtual Result<void> send(const Request& request) = 0;
  /// Of writers of ours. May get lost.
  virtual void assert_liveliness(const std::vector<EndpointId>& writers) = 0;
};

}  // namespace sft::core
