// A negotiation, and endpoints and requests of other nodes for it. The writer of this node has the id 100,
// and its reader the id 200.
#pragma once

#include <gtest/gtest.h>

#include <sensor_msgs/msg/PointCloud2.hpp>
#include <utility>
#include <vector>

#include "core/negotiation/negotiation.h"

namespace sft::core {


class NegotiationTest : public ::testing::Test {
 protected:
  using PointCloud2 = sensor_msgs::msg::PointCloud2;
  using F = PointCloud2::Field;
  static constexpr std::uint64_t here = 1;
  static constexpr std::uint64_t beside = 2;  ///< the host id of a container on the same machine
  static constexpr std::uint64_t elsewhere = std::uint64_t{1} << 32;

  NegotiationTest() { at_host(token(1)); }

  static HostToken token(std::uint8_t n) {
    HostToken t;
    t.bytes.fill(n);
    return t;
  }
  static std::vector<std::uint64_t> words(const Mask<PointCloud2>& mask) {
    return {mask.words.begin(), mask.words.end()};
  }

  void at_host(const HostToken& host) {
    negotiation.self_changed({.host = host, .network = here, .memory_state = "off"});
  }

  Endpoint endpoint(Role role, EndpointId id, std::uint64_t network = elsewhere, std::uint8_t host = 2) {
    Endpoint e;
    e.id = id;
    e.role = role;
    e.topic = "points";
    e.type_name = type.name();
    e.type_hash = type.hash();
    e.host = token(host);
    e.network = network;
    e.may_use_memory = e.may_use_network = true;
    e.addresses = {{0x0a000001, 7000, 1 << 20}};
    e.doorbell = {id, 1};
    e.max_sample_bytes = 1 << 20;
    e.request = {.reader = id,
                 .sequence = 1,
                 .mask_words = words(F::height | F::width),
                 .listening = {100},
                 .attached = {},
                 .begun = {}};
    return e;
  }

  Request request(EndpointId reader, std::uint64_t sequence, const Mask<PointCloud2>& mask,
                  std::vector<EndpointId> attached = {}) {
    return {.reader = reader,
            .sequence = sequence,
            .mask_words = words(mask),
            .listening = {100},
            .attached = std::move(attached),
            .begun = {}};
  }

  void our_writer() { negotiation.local_added(endpoint(Role::writer, 100), type); }
  void our_reader() { negotiation.local_added(endpoint(Role::reader, 200), type); }

  const TypeSupport type{detail::TypeTable<PointCloud2>::type};
  Negotiation negotiation;
};

}  // namespace sft::core
