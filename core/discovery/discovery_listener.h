// Receives what a node hears of others.
#pragma once

#include <string>

#include "core/control/control.h"

namespace sft::core {

/// A listener is told what others have announced, each thing once, by however many links it comes. It is
/// called on Cyclone's threads and on those of agents of this process, which must not be held up: post the
/// news, and return. One call at a time.
class DiscoveryListener {
 public:
  virtual void endpoint_seen(Endpoint endpoint) = 0;
  virtual void endpoint_departed(EndpointId id) = 0;
  /// The process of the endpoint does not answer. If it returns, the endpoint is seen again.
  virtual void endpoint_lost(EndpointId id) = 0;
  virtual void request_received(Request request) = 0;
  /// A node has reported of its own endpoints. Told to nodes that inquire.
  virtual void report_received(NodeReport report) = 0;
  /// A control sample, or the type description in one, was refused.
  virtual void control_malformed(std::string why) = 0;
  /// Discovery::vanilla() tells something else than before.
  virtual void vanilla_changed() {}
  /// Other interfaces are used now. Called on the thread that calls look_after().
  virtual void links_changed(const std::string& /*summary*/) {}
  /// Something of another process was missing on one link, which was made anew. Called on the same thread.
  virtual void link_was_renewed(const std::string& /*what*/) {}
  /// The user has to know that a participant has another release, that a peer by name has no address, or that
  /// the program has closed the sockets. Called on the same thread.
  virtual void warned(const std::string& /*what*/) {}

 protected:
  ~DiscoveryListener() = default;
};

}  // namespace sft::core
