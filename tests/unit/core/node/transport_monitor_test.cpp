// A node detects changes in the states of its two transports, and writes them to the log.
#include "core/node/transport_monitor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/core/seam/idle_ports.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class FakeMemory final : public IdleSharedMemory {
 public:
  Availability poll(Time) override { return availability; }
  std::string description() const override { return state; }
  HostToken host_token() const override {
    HostToken token;
    token.bytes.fill(daemon);
    return token;
  }

  bool lacks_daemon() const override { return lacks; }

  Availability availability = Availability::ready;
  std::string state = "works";
  std::uint8_t daemon = 1;
  bool lacks = false;
};

class FakeNetwork final : public IdleNetwork {
 public:
  Availability poll(Time) override { return availability; }
  std::string description() const override { return state; }
  std::vector<UdpAddress> addresses() const override { return addresses_now; }
  std::vector<Link> links() const override { return links_now; }
  bool network_changed() noexcept override { return ++looks, changed; }
  std::vector<Remark> take_remarks() override { return std::exchange(remarks, {}); }

  Availability availability = Availability::ready;
  std::string state = "works";
  std::vector<UdpAddress> addresses_now{{0x0a000001, 7000, 1 << 20}};
  std::vector<Link> links_now;
  std::vector<Remark> remarks;
  bool changed = true;
  int looks = 0;
};

class TransportMonitorTest : public ::testing::Test {
 protected:
  TransportMonitor::MemoryChange look_at_memory() { return monitor.look_at_memory(now); }
  TransportMonitor::NetworkChange look_at_network() {
    now += std::chrono::seconds(1);
    return monitor.look_at_network(now);
  }
  /// Sets the state of shared memory, and returns the lines that are logged because of it.
  std::vector<std::string> lines_if(Availability availability, const std::string& state) {
    memory.availability = availability;
    memory.state = state;
    lines.clear();
    if (look_at_memory().any) monitor.log_memory();
    return lines;
  }

  FakeMemory memory;
  FakeNetwork network;
  std::vector<std::string> lines;
  NodeLog log{"node", LogLevel::info, [this](LogLevel level, std::string_view text) {
                lines.push_back((level == LogLevel::info ? "info " : "louder ") + std::string(text));
              }};
  TransportMonitor monitor{&memory, &network, 5, log};
  Time now = std::chrono::steady_clock::now();
};

TEST_F(TransportMonitorTest, SharedMemoryIsReadyOnceItHasAHost) {
  EXPECT_FALSE(monitor.memory_ready());
  EXPECT_EQ(monitor.memory_state(), "starting");
  const auto change = look_at_memory();
  EXPECT_TRUE(change.any);
  EXPECT_TRUE(change.of_host);
  EXPECT_TRUE(change.of_state);
  EXPECT_TRUE(monitor.memory_ready());
  EXPECT_EQ(monitor.memory_state(), "works");
  EXPECT_EQ(monitor.self().host, memory.host_token());
  EXPECT_EQ(monitor.self().network, 5U);
  EXPECT_FALSE(look_at_memory().any);
}

TEST_F(TransportMonitorTest, AnotherDaemonIsAnotherHostInTheSameState) {
  look_at_memory();
  memory.daemon = 2;
  const auto change = look_at_memory();
  EXPECT_TRUE(change.of_host);
  EXPECT_FALSE(change.of_state);
}

TEST_F(TransportMonitorTest, SharedMemoryThatIsNotReadyHasNoHost) {
  look_at_memory();
  memory.availability = Availability::unavailable;
  EXPECT_TRUE(look_at_memory().of_host);
  EXPECT_EQ(monitor.self().host, HostToken{});
  EXPECT_FALSE(monitor.memory_ready());
}

TEST_F(TransportMonitorTest, OthersAreGivenTheLastFailureUntilSharedMemoryIsReady) {
  lines_if(Availability::starting, "starts sftd");
  EXPECT_EQ(monitor.self().memory_failure, "");
  lines_if(Availability::unavailable, "/dev/shm is too small");
  EXPECT_EQ(monitor.self().memory_failure, "/dev/shm is too small");
  lines_if(Availability::starting, "starts sftd");
  EXPECT_EQ(monitor.self().memory_failure, "/dev/shm is too small") << "an attempt is no news for others";
  lines_if(Availability::ready, "works");
  EXPECT_EQ(monitor.self().memory_failure, "");
}

TEST_F(TransportMonitorTest, AFailureThatOthersAreGivenIsAChangeOnce) {
  memory.availability = Availability::unavailable;
  memory.state = "/dev/shm is too small";
  EXPECT_TRUE(look_at_memory().of_failure);
  memory.availability = Availability::starting;
  memory.state = "starts sftd";
  EXPECT_FALSE(look_at_memory().of_failure);
  memory.availability = Availability::ready;
  EXPECT_TRUE(look_at_memory().of_failure);
}

TEST_F(TransportMonitorTest, ATransportThatIsRuledOutNeverChanges) {
  TransportMonitor none(nullptr, nullptr, 5, log);
  EXPECT_FALSE(none.look_at_memory(now).any);
  EXPECT_EQ(none.look_at_network(now), TransportMonitor::NetworkChange::none);
  EXPECT_EQ(none.memory_state(), "the node rules it out");
  EXPECT_FALSE(none.memory_ready());
  EXPECT_THAT(none.addresses(), IsEmpty());
}

TEST_F(TransportMonitorTest, TheSameFailureIsLoggedOnceAndTheAttemptsBetweenAreNot) {
  EXPECT_THAT(lines_if(Availability::unavailable, "/dev/shm is too small"),
              ElementsAre("louder node: shared memory: /dev/shm is too small"));
  EXPECT_THAT(lines_if(Availability::starting, "starts sftd"), IsEmpty());
  EXPECT_THAT(lines_if(Availability::unavailable, "/dev/shm is too small"), IsEmpty());
  EXPECT_THAT(lines_if(Availability::ready, "works"), ElementsAre("info node: shared memory: works"));
}

TEST_F(TransportMonitorTest, WithoutADaemonThatTheUserDoesNotWantThereIsNoWarning) {
  memory.lacks = true;
  EXPECT_THAT(lines_if(Availability::unavailable, "no sftd is running"),
              ElementsAre("info node: shared memory: no sftd is running"));
}

TEST_F(TransportMonitorTest, TheFirstFailureIsAWarningAndFurtherOnesAreNot) {
  EXPECT_THAT(lines_if(Availability::unavailable, "sftd could not be started: not found"),
              ElementsAre("louder node: shared memory: sftd could not be started: not found"));
  EXPECT_THAT(lines_if(Availability::unavailable, "sftd could not be started: no rights"),
              ElementsAre("info node: shared memory: sftd could not be started: no rights"));
}

TEST_F(TransportMonitorTest, AddressesAndLinksAreToldApart) {
  EXPECT_EQ(look_at_network(), TransportMonitor::NetworkChange::none) << "they are as at the beginning";
  network.links_now.emplace_back();
  EXPECT_EQ(look_at_network(), TransportMonitor::NetworkChange::links);
  EXPECT_EQ(monitor.links(), network.links_now);
  network.addresses_now.push_back({0x0b000001, 7000, 1 << 20});
  EXPECT_EQ(look_at_network(), TransportMonitor::NetworkChange::addresses);
  EXPECT_EQ(monitor.addresses(), network.addresses_now);
  EXPECT_EQ(look_at_network(), TransportMonitor::NetworkChange::none);
}

TEST_F(TransportMonitorTest, AddressesAreAskedForOnlyIfTheNetworkMayHaveChangedAndNotAllTheTime) {
  network.changed = false;
  network.addresses_now.clear();
  EXPECT_EQ(look_at_network(), TransportMonitor::NetworkChange::none);
  EXPECT_EQ(network.looks, 1);
  monitor.look_at_network(now + std::chrono::milliseconds(199));
  EXPECT_EQ(network.looks, 1);
  monitor.look_at_network(now + std::chrono::milliseconds(200));
  EXPECT_EQ(network.looks, 2);
}

TEST_F(TransportMonitorTest, UdpThatFailsIsAnErrorThatIsLoggedOnce) {
  network.availability = Availability::unavailable;
  network.state = "the system has stopped io_uring";
  look_at_network();
  look_at_network();
  EXPECT_THAT(lines, ElementsAre("louder node: UDP: the system has stopped io_uring"));
}

TEST_F(TransportMonitorTest, RemarksOfTheNetworkAreLoggedAndWarningsThatComeAgainWaitForAPauseOfEachHost) {
  const auto limit = [](const std::string& host) {
    return Network::Remark{LogLevel::warning,
                           "datagrams longer than 1252 bytes do not arrive at '" + host + "'"};
  };
  const auto lines_of = [this](std::vector<Network::Remark> remarks) {
    network.remarks = std::move(remarks);
    lines.clear();
    look_at_network();
    return lines;
  };
  EXPECT_THAT(lines_of({limit("10.0.0.1")}),
              ElementsAre("louder node: UDP: datagrams longer than 1252 bytes do not arrive at '10.0.0.1'"));
  EXPECT_THAT(lines_of({limit("10.0.0.1")}), IsEmpty());
  EXPECT_THAT(lines_of({limit("10.0.0.2")}), SizeIs(1));
  EXPECT_THAT(lines_of({{LogLevel::info, "long datagrams arrive"}}),
              ElementsAre("info node: UDP: long datagrams arrive"));
}

TEST_F(TransportMonitorTest, LooksForSharedMemoryOftenAsLongAsItMayCome) {
  const auto next_with = [&](Availability availability, bool lacks_daemon) {
    memory.availability = availability;
    memory.lacks = lacks_daemon;
    look_at_memory();
    return monitor.next_look(now);
  };
  EXPECT_EQ(next_with(Availability::starting, false), now + std::chrono::milliseconds(200));
  EXPECT_EQ(next_with(Availability::unavailable, false), now + std::chrono::milliseconds(200));
  EXPECT_EQ(next_with(Availability::unavailable, true), Time::max()) << "nobody is about to start a daemon";
  EXPECT_EQ(next_with(Availability::ready, false), Time::max());
}

}  // namespace
}  // namespace sft::core
