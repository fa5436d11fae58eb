#include "tests/pairs/echo.h"

#include <ranges>
#include <stdexcept>
#include <variant>

namespace sft::test {

namespace {

core::Request marker_request(std::uint64_t sequence) {
  core::Request request;
  request.reader = 1;
  request.sequence = sequence;
  return request;
}

core::Endpoint marker_like(const core::Endpoint& model) {
  core::Endpoint marker = model;
  marker.role = core::Role::reader;
  marker.node = "echo";
  marker.addresses.clear();  // without addresses, no publisher can send samples to this reader
  marker.request = marker_request(1);
  marker.id = marker.request.reader;
  return marker;
}

}  // namespace

Echo::Echo() {
  auto discovery = core::Discovery::open({}, [] {});
  if (!discovery) throw std::runtime_error(discovery.error().message);
  discovery_ = std::move(*discovery);
  for (const core::Role role : {core::Role::writer, core::Role::reader}) discovery_->hear(role);
}

void Echo::repeat() {
  for (const core::DiscoveryEvent& event : discovery_->take_events()) {
    if (const auto* const seen = std::get_if<core::EndpointSeen>(&event)) endpoints_.push_back(**seen);
    if (const auto* const request = std::get_if<core::Request>(&event)) requests_.push_back(*request);
  }
  for (const core::Request& request : requests_ | std::views::reverse) discovery_->send(request);
  for (const core::Endpoint& endpoint : endpoints_ | std::views::reverse) discovery_->announce(endpoint);
  discovery_->announce(marker_like(endpoints_.at(0)));
  discovery_->send(marker_request(2));
}

}  // namespace sft::test
