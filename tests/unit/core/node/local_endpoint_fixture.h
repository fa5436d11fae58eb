// A fixture for single endpoints of a node, without the node's reconciler. The test provides the table of
// endpoints, the transports and discovery.
#pragma once

#include "tests/unit/core/node/reconciler_fixture.h"
#include "tests/unit/core/node/test_memory.h"

namespace sft::core {

class LocalEndpointTest : public ::testing::Test {
 protected:
  LocalEndpointTest() {
    negotiation.self_changed({.host = memory.host_token(), .network = 1, .memory_state = "ready"});
  }

  /// Returns an endpoint on this host that uses shared memory only.
  Endpoint here(Role role, EndpointId id) const {
    Endpoint e = over_network(role, id);
    e.network = 1;
    e.may_use_network = false;
    e.may_use_memory = true;
    e.addresses.clear();
    e.host = memory.host_token();
    return e;
  }
  /// Returns an endpoint on another host.
  Endpoint over_network(Role role, EndpointId id) const {
    Endpoint e;
    e.id = id;
    e.role = role;
    e.node_id = id;
    e.topic = "points";
    e.type_name = type.name();
    e.type_hash = type.hash();
    e.network = id;
    e.may_use_network = true;
    e.addresses = {{0x0a000001, 7000, 1 << 20}};
    e.request = {.reader = id,
                 .sequence = 1,
                 .mask_words = mask.to_words(),
                 .listening = {},
                 .attached = {},
                 .begun = {}};
    return e;
  }
  static Time soon() { return std::chrono::steady_clock::now() + std::chrono::minutes(1); }

  const TypeSupport type{detail::TypeTable<PointCloud2>::type};
  const FieldMask mask = type.closed(FieldMask(F::height | F::width));
  std::vector<std::string> logged;
  NodeLog log{"node", LogLevel::warning,
              [this](LogLevel, std::string_view text) { logged.emplace_back(text); }};
  TestDiscovery discovery;
  TestTransport network;
  TestMemory memory;
  Negotiation negotiation;
  PortAttempts attempts{log};
  NodeContext node{negotiation, discovery, attempts, log, &memory, &network};
};

}  // namespace sft::core
