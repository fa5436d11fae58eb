// The participant on one link: the control topics in one Cyclone domain. The only files of the core that see
// Cyclone are this one, control_topic, topic_endpoint, control_words, take_all, control_qos, dds_domain and
// cyclone_settings.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/life_signs.h"
#include "core/discovery/participants.h"
#include "core/discovery/pulse.h"
#include "core/discovery/pulse_socket.h"
#include "core/discovery/speakers.h"
#include "core/platform/clock.h"
#include "sft/result.h"

namespace sft::core {

class CycloneDomain;

/// A listener is told what others say on the links. It is called on Cyclone's threads, on several at once.
class LinkListener {
 public:
  virtual void endpoint_came(const Speaker& speaker, Endpoint endpoint) = 0;
  virtual void endpoint_withdrawn(const Speaker& speaker, EndpointId id) = 0;
  /// Nobody keeps the endpoint alive any more on that link.
  virtual void endpoint_unheard(LinkId link, EndpointId id) = 0;
  virtual void request_came(const Speaker& speaker, Request request) = 0;
  /// `lease`: how long Cyclone waits for the next one before it says that the node is unheard.
  virtual void assertion_came(const Speaker& speaker, Assertion assertion,
                              std::chrono::milliseconds lease) = 0;
  virtual void node_unheard(LinkId link, NodeId id) = 0;
  /// A pulse came after `since`, of one of the participants if it is known. It is told within hear_pulses().
  /// Returns false if the pulse counts for nothing.
  virtual bool pulse_came(LinkId link, const Pulse& pulse, const Participants& participants, Time since) = 0;
  virtual void participant_came(const Speaker& speaker) = 0;
  /// The participant belongs to a node that speaks with us: one with this version of the control topics, and
  /// secured if we are. May be told more than once.
  virtual void participant_speaks(const Speaker& speaker) = 0;
  /// The participant belongs to a node with another version of the control topics. May be told more than
  /// once.
  virtual void other_release_seen(const Speaker& speaker, std::uint32_t version) = 0;
  /// The participant complains that it has heard something else of us on that link than we say.
  virtual void complaint_came(const Speaker& speaker) = 0;
  virtual void participant_departed(const Speaker& speaker) = 0;
  /// A reader or writer of the participant's control topics is there, or is not any more.
  virtual void endpoint_matched(const Speaker& speaker, bool is_there) = 0;
  virtual void sample_malformed(std::string why) = 0;

 protected:
  ~LinkListener() = default;
};

class DiscoveryLink {
 public:
  /// `domain` is kept as long as the link lives; null: the domain `number` of the program itself.
  /// `is_secured`: by DDS Security. `pulses`: nothing if there are none on the link.
  struct Place {
    LinkId link = 0;
    std::shared_ptr<const CycloneDomain> domain;
    std::uint32_t number = 0;
    bool is_secured = false;
    std::optional<PulseSocket::Place> pulses{};
  };
  /// Participants and listener outlive the link.
  static Result<std::unique_ptr<DiscoveryLink>> open(const Place& place, const LifeSigns& signs,
                                                     Participants& participants, LinkListener& listener);
  /// Waits until no listener runs any more.
  virtual ~DiscoveryLink() = default;

  // One thread at a time.

  /// Listens to announcements of that role from now on, and to requests if it is that of readers.
  virtual Result<void> hear(Role role) = 0;
  virtual Result<void> write(const Endpoint& endpoint) = 0;
  virtual Result<void> write(const Request& request) = 0;
  /// Lets full signs of life go and come, which costs everybody two endpoints of this participant.
  virtual Result<void> exchange_full_signs() = 0;
  /// Gives a sign of life as a pulse, and by Cyclone if it has to be a full one, or if there are no pulses.
  /// Before exchange_full_signs() it is a pulse only.
  virtual void write(const Assertion& assertion, bool is_full) = 0;
  /// Tells the listener of the pulses that have come since the last call, which was at `since`. Returns false
  /// if one of them counts for nothing.
  virtual bool hear_pulses(Time since) = 0;
  virtual void dispose(EndpointId id, Role role) = 0;
  /// The node does not live any more, though its process does.
  virtual void end_life(NodeId node) = 0;
  /// Makes the participant known once more to whoever is there.
  virtual void greet() = 0;
  /// Tells everybody, and so these participants, that something else came of them than they say. At most
  /// complaints_max (participant_mark.h) participants.
  virtual void complain(const std::vector<AnnouncerId>& participants) = 0;
  /// Waits until others have what was written, or not longer.
  virtual void flush(std::chrono::milliseconds patience) = 0;
};

}  // namespace sft::core
