#include <array>
#include <cstdlib>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/micro/operation.h"
#include "core/negotiation/negotiation.h"

namespace sft::bench::micro {

namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

/// A publisher, and the readers of its topic on other hosts.
class Topic {
 public:
  explicit Topic(std::size_t readers) : readers_(readers) {
    negotiation_.self_changed({.host = host(1), .network = 1, .memory_state = "off"});
    negotiation_.local_added(endpoint(core::Role::writer, writer_), type_);
    for (std::size_t i = 0; i < readers; ++i)
      negotiation_.endpoint_seen(endpoint(core::Role::reader, first_reader_ + i));
    change_a_request();
    if (negotiation_.serving(writer_).network.size() != readers) std::abort();
  }

  /// Makes the next reader request other fields. The readers take turns.
  void change_a_request() {
    ++sequence_;
    const core::EndpointId reader = first_reader_ + sequence_ % readers_;
    negotiation_.request_received(request(reader, masks_[sequence_ / readers_ % masks_.size()]));
    keep(negotiation_.serving(writer_).network.size());
  }

 private:
  static core::HostToken host(std::uint8_t number) {
    core::HostToken token;
    token.bytes.fill(number);
    return token;
  }
  core::Request request(core::EndpointId reader, const FieldMask& mask) const {
    return {.reader = reader,
            .sequence = sequence_ + 1,
            .mask_words = mask.to_words(),
            .listening = {writer_},
            .attached = {},
            .begun = {}};
  }
  core::Endpoint endpoint(core::Role role, core::EndpointId id) const {
    core::Endpoint endpoint;
    endpoint.id = id;
    endpoint.role = role;
    endpoint.topic = "points";
    endpoint.type_name = type_.name();
    endpoint.type_hash = type_.hash();
    endpoint.host = host(2);
    endpoint.network = std::uint64_t{1} << 32;
    endpoint.may_use_memory = endpoint.may_use_network = true;
    endpoint.addresses = {{0x0a000001, static_cast<std::uint16_t>(7000 + id), 1 << 20}};
    endpoint.doorbell = {id, 1};
    endpoint.max_sample_bytes = 1 << 20;
    endpoint.request = request(id, masks_[0]);
    return endpoint;
  }

  static constexpr core::EndpointId writer_ = 100, first_reader_ = 200;
  const std::size_t readers_;
  const TypeSupport type_{detail::TypeTable<PointCloud2>::type};
  const std::array<FieldMask, 2> masks_{FieldMask(F::height | F::width), FieldMask(F::data | F::width)};
  std::uint64_t sequence_ = 0;
  core::Negotiation negotiation_;
};

Operation negotiating(std::size_t readers) {
  const auto topic = std::make_shared<Topic>(readers);
  return {"negotiate_readers_" + std::to_string(readers), small_copy_bytes,
          batch_of([topic] { topic->change_a_request(); })};
}

}  // namespace

Operations negotiate_operations() { return {negotiating(1), negotiating(16)}; }

}  // namespace sft::bench::micro
