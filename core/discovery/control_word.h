// What somebody says on the control topics: who says it, and what. Nothing of Cyclone is in it.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/participants.h"

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

}  // namespace sft::core
