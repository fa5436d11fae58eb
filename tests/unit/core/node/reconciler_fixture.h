// A reconciler with ports, transports and discovery that the test controls.
#pragma once

#include "core/node/reconciler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sensor_msgs/msg/PointCloud2.hpp>
#include <set>

#include "tests/support/eventually.h"
#include "tests/unit/core/seam/idle_ports.h"

namespace sft::core {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class TestWriterPort final : public IdleNetworkWriter {
 public:
  void set_routes(std::vector<Route> set) override {
    routes = std::move(set);
    ++changes;
  }
  bool history_sent(EndpointId) noexcept override { return history_left; }
  Counters counters() const noexcept override { return ++looks, Counters{}; }
  std::vector<Route> routes;
  bool history_left = true;
  int changes = 0;
  mutable int looks = 0;  ///< the number of times that the counters were read
};

/// The state of a port: the writers to which it is connected, and the results of its functions, which the
/// test sets.
struct Connections {
  std::set<EndpointId> writers;
  /// The sources of connected writers, in the order in which they were announced again.
  std::vector<Source> announced;
  /// The reason why no connection is possible at present; empty: connections are possible.
  std::string refusal;
  SampleHandle sample;  ///< the sample that take() returns next
  int ports_gone = 0;
  int looks = 0;  ///< the number of times that the counters were read
};

class TestReaderPort final : public IdleNetworkReader {
 public:
  explicit TestReaderPort(Connections& connections) : connections_(connections) {}
  ~TestReaderPort() override { ++connections_.ports_gone; }
  SampleHandle take() noexcept override { return std::move(connections_.sample); }
  Result<void> connect(const Source& source) override {
    if (!connections_.refusal.empty()) return fail(Errc::unavailable, connections_.refusal);
    connections_.writers.insert(source.writer);
    return {};
  }
  bool connected(EndpointId writer) const noexcept override { return connections_.writers.contains(writer); }
  void announced(const Source& source) override { connections_.announced.push_back(source); }
  void disconnect(EndpointId writer) noexcept override { connections_.writers.erase(writer); }
  ReaderPort::Counters counters() const noexcept override { return ++connections_.looks, Counters{}; }

 private:
  Connections& connections_;
};

class TestDiscovery final : public Discovery {
 public:
  Configuration configuration() const override { return {}; }
  std::vector<DiscoveryEvent> take_events() override { return {}; }
  void hear(Role) override {}
  std::vector<KnownPublisher> publishers_of(std::string_view) const override { return {}; }
  void announce(const Endpoint& endpoint) override { announced.push_back(endpoint); }
  void withdraw(EndpointId) override {}
  void send(const Request& request) override { sent.push_back(request); }
  void inquire(const std::set<Inquiry>& inquiries) override { inquired = inquiries; }
  Inquiries inquiries() const override { return asked; }
  void report(const NodeReport& report) override { reports.push_back(report); }
  Vanilla vanilla() const override { return {}; }
  Time look_after(Time) override { return next_look; }
  std::vector<Endpoint> announced;
  std::vector<Request> sent;
  std::set<Inquiry> inquired;  ///< the last set of inquiries of this node
  Inquiries asked;
  std::vector<NodeReport> reports;
  Time next_look = Time::max();  ///< the time that look_after() returns
};

/// A network transport that has addresses and does nothing.
class TestTransport final : public IdleNetwork {
 public:
  std::vector<UdpAddress> addresses() const override { return addresses_now; }
  std::vector<UdpAddress> addresses_now{{0x0a000001, 7000, 1 << 20}};
};

class ReconcilerTest : public ::testing::Test {
 protected:
  Endpoint endpoint(Role role, EndpointId id) const {
    Endpoint e;
    e.id = id;
    e.role = role;
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

  std::shared_ptr<SubscriberCore> our_reader(EndpointId id, detail::untyped::Callback callback = nullptr) {
    const auto port = std::make_shared<TestReaderPort>(connections);
    auto core =
        std::make_shared<SubscriberCore>(SubscriberCore::Spec{.topic = "points",
                                                              .type = &type,
                                                              .feeds = {{.id = id, .selection = mask}},
                                                              .options = {},
                                                              .callback = std::move(callback)},
                                         bells->at(1), nullptr);
    core->ports().set_network(port);
    reconciler.add_reader(endpoint(Role::reader, id), {core, port});
    reconciler.reconcile();
    return core;
  }
  std::shared_ptr<PublisherCore> our_writer(EndpointId id, const std::shared_ptr<NetworkWriter>& port) {
    PublisherCore::Spec spec{id, "points", &type, 1 << 16};
    spec.on_readers_changed = [this](const PublisherStatus&) { ++readers_changed; };
    auto core = std::make_shared<PublisherCore>(std::move(spec), BufferPool::make(1 << 20), port);
    reconciler.add_writer(endpoint(Role::writer, id), core);
    reconciler.reconcile();
    return core;
  }
  void requested(Request request) {
    reconciler.take(request);
    reconciler.reconcile();
  }
  void writer_seen(EndpointId id) {
    reconciler.take(std::make_shared<const Endpoint>(endpoint(Role::writer, id)));
    reconciler.reconcile();
  }
  void writer_departed(EndpointId id) {
    reconciler.take(EndpointDeparted{id});
    reconciler.reconcile();
  }

  const TypeSupport type{detail::TypeTable<PointCloud2>::type};
  const FieldMask mask = type.closed(FieldMask(F::height | F::width));
  const std::unique_ptr<DoorbellPage> bells = DoorbellPage::create();
  int readers_changed = 0;
  std::vector<std::string> logged;
  Dispatcher dispatcher{bells->at(0), "test"};
  Connections connections;
  TestDiscovery discovery;
  TestTransport network;
  NodeLog log{"node", LogLevel::warning,
              [this](LogLevel, std::string_view text) { logged.emplace_back(text); }};
  Reconciler reconciler{1, nullptr, &network, discovery, dispatcher, log};
};

}  // namespace sft::core
