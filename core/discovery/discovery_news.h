// The news that LinkMerge makes of all that is heard on the links.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/speakers.h"

namespace sft::core {

struct EndpointSeen {
  std::shared_ptr<const Endpoint> endpoint;
  /// Links by which the endpoint's node was heard and is not heard any more, although it is by another link:
  /// the way there is cut, and samples would not arrive that way either.
  std::vector<LinkId> silent{};
};
struct EndpointDeparted {
  EndpointId id;
};
struct EndpointLost {
  EndpointId id;
};
struct NodeLost {
  NodeId id;
};
/// A participant spoke in the name of another one, or said too much.
struct Refused {
  std::string why;
};
using News =
    std::variant<EndpointSeen, EndpointDeparted, EndpointLost, Request, Assertion, NodeLost, Refused>;

}  // namespace sft::core
