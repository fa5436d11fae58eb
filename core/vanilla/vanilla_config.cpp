#include "core/vanilla/vanilla_config.h"

#include <string_view>

#include "core/discovery/cyclone_settings.h"

namespace sft::core {

namespace {

/// Participants with an index are few where peers are asked, and ROS 2's nodes need one each. This one has
/// none: it asks the peers, and they answer.
std::string settings_of_ros(const RosDiscovery& ros) {
  if (ros.loopback_only) return "<General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></></>";
  std::string peers = ros.localhost_only ? "<Peer address=\"localhost\"/>" : "";
  for (const std::string& peer : ros.peers) peers += "<Peer address=\"" + peer + "\"/>";
  if (peers.empty()) return {};
  return (ros.localhost_only ? "<General><AllowMulticast>false</></>" : "") +
         xml_element("Discovery",
                     "<ParticipantIndex>none</><MaxAutoParticipantIndex>32</>" + xml_element("Peers", peers));
}

}  // namespace

/// Multicasts of samples would reach the ports of all links of this network. Bursts of large samples overrun
/// small receive buffers, since DDS writers do not pace them. A participant that joins asks those that were
/// there before for their endpoints, after PreEmptiveAckDelay: sooner than usual, but not before they know
/// this participant, since Cyclone would ask again only 100 ms later. The one setting that SFT cannot do
/// without concerns the runtime of iceoryx, of which a process has one.
Result<VanillaConfig> vanilla_config(std::uint32_t domain, const std::string& user_config,
                                     const RosDiscovery& ros) {
  const Result<CycloneSettings> user = CycloneSettings::read(user_config, domain);
  if (!user) return tl::unexpected(user.error());
  const std::string users = user->for_any_domain({domain_number_path});
  constexpr std::string_view ours =
      "<General><AllowMulticast>spdp</></><Sizing><ReceiveBufferSize>256 KiB</></>"
      "<Internal><SocketReceiveBufferSize min=\"default\" max=\"4MB\"/><WriterLingerDuration>0 s</>"
      "<PreEmptiveAckDelay>3 ms</></>";
  const std::string insisted =
      xml_element("SharedMemory", xml_element("Enable", "false")) +
      xml_element("Discovery", xml_element("ExternalDomainId", user->domain_on_wire()));
  const std::string of_ros = settings_of_ros(ros);
  return VanillaConfig{.text = xml_document(ours) + "," + (of_ros.empty() ? "" : xml_document(of_ros) + ",") +
                               (users.empty() ? "" : users + ",") + xml_document(insisted),
                       .is_secured = user->is_secured()};
}

}  // namespace sft::core
