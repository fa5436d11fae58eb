// Participants of the control topics that say whatever they like, on the network and, for nodes of their own
// host, on the loopback. They hear what the honest nodes announce.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/control/control.h"
#include "core/control/control_codec.h"

namespace sft::hostile {

class ControlVoice {
 public:
  /// Speaks in the domain that the honest nodes use. Throws if there is no network.
  ControlVoice();
  ~ControlVoice();
  ControlVoice(const ControlVoice&) = delete;
  ControlVoice& operator=(const ControlVoice&) = delete;

  /// Everything that honest nodes announced, with the newest request of each reader.
  std::vector<core::Endpoint> heard();
  std::vector<core::Endpoint> heard(core::Role role);

  // All of these may be said in anybody's name.

  void announce(const core::Endpoint& endpoint);
  /// Writes the endpoint as it is: lengths, versions and names are not checked.
  void announce_raw(const sft_control_Endpoint& endpoint);
  void request(const core::Request& request);
  void dispose(core::EndpointId endpoint);
  /// Takes an endpoint of one's own back without a word of disposal.
  void unregister(core::EndpointId endpoint);
  void assert_life(core::NodeId node, const std::vector<core::EndpointId>& writers = {},
                   const std::vector<core::Progress>& progress = {});
  void assert_life(const core::Assertion& assertion);
  void dispose_life(core::NodeId node);

 private:
  class Link;
  std::vector<std::unique_ptr<Link>> links_;
  std::map<core::EndpointId, core::Endpoint> heard_;
};

/// The name of nodes that attackers make up.
inline constexpr const char* made_up = "made up";

/// A reader that would fit this writer, at an address, as another node would announce it. It asks for all
/// fields and listens to the writer.
core::Endpoint made_up_reader(const core::Endpoint& writer, std::uint64_t id, std::uint64_t node,
                              std::vector<core::UdpAddress> addresses);
/// A writer that would fit this reader.
core::Endpoint made_up_writer(const core::Endpoint& reader, std::uint64_t id, std::uint64_t node);

}  // namespace sft::hostile
