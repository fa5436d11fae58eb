// What others say on the control topics, as it comes out of Cyclone's readers: who says it, and what. The
// samples are checked (control_codec.h), and nothing of Cyclone remains in them.
#pragma once

#include <dds/dds.h>

#include <chrono>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/participants.h"
#include "core/discovery/remote_endpoints.h"

namespace sft::core {

struct EndpointWithdrawn {
  EndpointId id = 0;
};
/// Nobody keeps the endpoint alive any more.
struct EndpointUnheard {
  EndpointId id = 0;
};
struct SignOfLife {
  Assertion assertion;
  std::chrono::milliseconds lease{};  ///< how long Cyclone waits for the next one
};
struct NodeUnheard {
  NodeId id = 0;
};
/// A reader or writer of the participant's has met ours, or is gone.
struct EndpointMet {};
struct EndpointGone {};
struct SampleMalformed {
  std::string why;
};

struct ControlWord {
  /// The participant that says it. Nobody if that was gone before it was known.
  std::optional<Participants::Guid> speaker{};
  std::variant<Endpoint, Request, EndpointWithdrawn, EndpointUnheard, SignOfLife, NodeUnheard, EndpointMet,
               EndpointGone, SampleMalformed>
      what;
};
using ControlWords = std::vector<ControlWord>;

// Each takes all that its reader has. `writers`: those behind the samples; new ones are entered.

ControlWords take_writers(dds_entity_t reader, RemoteEndpoints& writers);
ControlWords take_readers(dds_entity_t reader, RemoteEndpoints& writers);
ControlWords take_assertions(dds_entity_t reader, RemoteEndpoints& writers);

/// Empty if the writer, or reader, is not matched any more.
std::optional<Participants::Guid> publishing_participant(dds_entity_t reader, dds_instance_handle_t writer);
std::optional<Participants::Guid> subscribing_participant(dds_entity_t writer, dds_instance_handle_t reader);

Participants::Guid to_guid(const dds_guid_t& guid);

}  // namespace sft::core
