#include "tests/pairs/echo.h"

#include <ranges>
#include <stdexcept>

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
  auto discovery = core::Discovery::open({}, *this);
  if (!discovery) throw std::runtime_error(discovery.error().message);
  discovery_ = std::move(*discovery);
  for (const core::Role role : {core::Role::writer, core::Role::reader}) discovery_->hear(role);
}

void Echo::endpoint_seen(core::Endpoint endpoint) {
  const std::scoped_lock lock(mutex_);
  endpoints_.push_back(std::move(endpoint));
}

void Echo::request_received(core::Request request) {
  const std::scoped_lock lock(mutex_);
  requests_.push_back(std::move(request));
}

void Echo::repeat() {
  std::vector<core::Endpoint> endpoints;
  std::vector<core::Request> requests;
  {
    const std::scoped_lock lock(mutex_);
    endpoints = endpoints_;
    requests = requests_;
  }
  for (const core::Request& request : requests | std::views::reverse) discovery_->send(request);
  for (const core::Endpoint& endpoint : endpoints | std::views::reverse) discovery_->announce(endpoint);
  discovery_->announce(marker_like(endpoints.at(0)));
  discovery_->send(marker_request(2));
}

}  // namespace sft::test
