// Receives what a node learns of other nodes.
#pragma once

#include <string>

#include "core/control/control.h"

namespace sft::core {

/// A listener is notified of what other nodes announce: once of each item, however many links bring it. It is
/// called by Cyclone's threads and by agents of this process, one call at a time. They must not be held up,
/// so the listener should only post the news.
class DiscoveryListener {
 public:
  virtual void endpoint_seen(Endpoint endpoint) = 0;
  virtual void endpoint_departed(EndpointId id) = 0;
  /// The process of the endpoint is silent. If it returns, endpoint_seen() is called again.
  virtual void endpoint_lost(EndpointId id) = 0;
  virtual void request_received(Request request) = 0;
  /// A node has reported on its own endpoints. Called for nodes that inquire.
  virtual void report_received(NodeReport report) = 0;
  /// A control sample, or the type description in one, was refused.
  virtual void control_malformed(std::string why) = 0;
  /// The result of Discovery::vanilla() has changed.
  virtual void vanilla_changed() {}
  /// The interfaces in use have changed. Called on the thread that calls look_after().
  virtual void links_changed(const std::string& /*summary*/) {}
  /// A record of another process was missing on one link, so that link was made anew. Called on the same
  /// thread.
  virtual void link_was_renewed(const std::string& /*what*/) {}
  /// The user has to know that a participant has another release, that a peer by name has no address, or that
  /// the program has closed the sockets. Called on the same thread.
  virtual void warned(const std::string& /*what*/) {}

 protected:
  ~DiscoveryListener() = default;
};

}  // namespace sft::core
