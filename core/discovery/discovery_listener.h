// What a node hears of others.
#pragma once

#include <string>

#include "core/control/control.h"

namespace sft::core {

/// Told what others announced, each thing once, however many links it comes by. Called on Cyclone's threads,
/// which must not be held up: post it and return. One call at a time.
class DiscoveryListener {
 public:
  virtual void endpoint_seen(Endpoint endpoint) = 0;
  virtual void endpoint_departed(EndpointId id) = 0;
  /// Its node stopped answering; if it returns, the endpoint is seen again.
  virtual void endpoint_lost(EndpointId id) = 0;
  virtual void request_received(Request request) = 0;
  /// A node says every now and then that it lives, and which of its writers do.
  virtual void liveliness_asserted(Assertion assertion) = 0;
  /// It has not said so for its lease.
  virtual void node_lost(NodeId id) = 0;
  /// A control sample, or the type description in one, was refused.
  virtual void control_malformed(std::string why) = 0;
  /// Other interfaces are used now. On the thread that calls look_after().
  virtual void links_changed(const std::string& /*summary*/) {}
  /// Somebody was not heard any more on one link, though he is there, and so the link was made anew, or could
  /// not be. Likewise.
  virtual void link_was_deaf(const std::string& /*what*/) {}
  /// Somebody is there with whom this node cannot speak. Likewise.
  virtual void other_release_found(const std::string& /*what*/) {}

 protected:
  ~DiscoveryListener() = default;
};

}  // namespace sft::core
