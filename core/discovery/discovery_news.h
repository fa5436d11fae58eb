// The news that LinkMerge makes of all that is heard on the links.
#pragma once

#include <memory>
#include <optional>
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

/// The endpoint that the news are about, if they are about one.
inline std::optional<EndpointId> endpoint_of(const News& news) {
  if (const auto* const seen = std::get_if<EndpointSeen>(&news)) return seen->endpoint->id;
  if (const auto* const departed = std::get_if<EndpointDeparted>(&news)) return departed->id;
  if (const auto* const lost = std::get_if<EndpointLost>(&news)) return lost->id;
  if (const auto* const request = std::get_if<Request>(&news)) return request->reader;
  return std::nullopt;
}

}  // namespace sft::core
