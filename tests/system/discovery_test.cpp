// Nodes on isolated hosts find each other: by multicast, by a list of peers, over links that lose a fifth of
// all packets, and on hosts with several networks.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <sft/sft.h>
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>

#include "core/discovery/dds_config.h"
#include "core/platform/domain_id.h"
#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/system/node_process.h"
#include "tools/hosts/network.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

/// The state that a process reports while it runs.
struct Report {
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> matched{0};  ///< the number of connected publishers or served subscribers
  std::atomic<std::uint64_t> taken{0};
  std::atomic<std::uint64_t> liveliness_lost{0};
  std::atomic<std::uint64_t> out_of_order{0};  ///< samples that did not follow the previous sample
  std::atomic<std::size_t> addresses{0};       ///< the number of addresses that the publisher's node reports
  std::atomic<double> share_of_a_core{1};      ///< the CPU time of the process divided by the time for which
                                               ///< it waited
};

class NodeProcess : public NodeProcessWith<Report> {
 public:
  using NodeProcessWith::NodeProcessWith;

  bool matches(std::size_t others, std::chrono::milliseconds within = hang_timeout) const {
    return eventually([&] { return report().matched == others; }, within);
  }
  bool takes_samples(std::chrono::milliseconds within = hang_timeout) const {
    const std::uint64_t before = report().taken;
    return eventually([&] { return report().taken > before + 10; }, within);
  }
};

void publish(Node& node, Report& report) {
  auto publisher = node.publisher<PointCloud2>("points").value();
  for (std::uint32_t i = 1;; ++i) {
    std::size_t served = 0;
    for (const auto& reader : publisher.status().readers) {
      served += reader.served && reader.mask == FieldMask(F::height | F::width) ? 1 : 0;
    }
    report.matched = served;
    publisher.publish({.height = i});
    poll(nullptr, 0, 5);
  }
}

void subscribe(Node& node, Report& report) {
  auto subscriber = node.subscriber<PointCloud2, F::height | F::width>("points").value();
  for (;;) {
    std::size_t matched = 0;
    for (const auto& writer : subscriber.status().writers) matched += writer.matched && writer.alive ? 1 : 0;
    report.matched = matched;
    if (subscriber.wait(5ms) && subscriber.take()) ++report.taken;
  }
}

/// Publishes no samples, so that only the heartbeats of its node show that the publisher is alive.
void promise_life(Node& node, Report&) {
  const auto publisher = node.publisher<PointCloud2>("points", {.liveliness_lease = 500ms}).value();
  for (;;) pause();
}

void expect_life(Node& node, Report& report) {
  const auto count = [&](const Event& event) {
    if (event.kind == Event::Kind::liveliness_lost) ++report.liveliness_lost;
  };
  auto subscriber =
      node.subscriber<PointCloud2, F::height>("points", {.liveliness_lease = 1s, .on_event = count}).value();
  for (;;) {
    const auto writers = subscriber.status().writers;
    report.matched =
        static_cast<std::size_t>(std::ranges::count_if(writers, &SubscriberStatus::Writer::matched));
    poll(nullptr, 0, 5);
  }
}

void publish_nothing(Node& node, Report& report) {
  const auto publisher = node.publisher<PointCloud2>("points").value();
  for (;; poll(nullptr, 0, 50)) report.matched = publisher.status().readers.size();
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) { return time.tv_sec + time.tv_usec / 1e6; };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void wait_in_vain(Node& node, Report& report) {
  auto subscriber = node.subscriber<PointCloud2, F::height>("points").value();
  const auto hears_one = [&] {
    const auto writers = subscriber.status().writers;
    return writers.size() == 1 && writers[0].connected;
  };
  while (!hears_one()) subscriber.wait(20ms);
  subscriber.wait(2s);  // the rest of discovery must not be measured
  const double before = cpu_seconds();
  const auto begin = std::chrono::steady_clock::now();
  subscriber.wait(4s);
  const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - begin;
  report.share_of_a_core = (cpu_seconds() - before) / waited.count();
  report.matched = 1;
  for (;;) pause();
}

/// Publishes samples with consecutive heights.
void publish_reliably(Node& node, Report& report) {
  auto publisher = node.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  std::vector<std::uint8_t> data(20'000);
  for (std::uint32_t i = 1;;) {
    const auto status = publisher.status();
    report.matched =
        static_cast<std::size_t>(std::ranges::count_if(status.readers, &PublisherStatus::Reader::served));
    if (report.matched != 0) publisher.publish({.height = i++, .data = data});
    poll(nullptr, 0, 2);
  }
}

/// Reports samples that are missing or out of order after the first sample.
void subscribe_reliably(Node& node, Report& report) {
  auto subscriber =
      node.subscriber<PointCloud2, F::height | F::data>("points", {.reliability = reliable, .depth = 1000})
          .value();
  std::uint32_t last = 0;
  for (;;) {
    subscriber.wait(5ms);
    while (auto sample = subscriber.take()) {
      if (last != 0 && sample->height() != last + 1) ++report.out_of_order;
      last = sample->height();
      ++report.taken;
    }
    for (const DomainSnapshot::Endpoint& one : node.domain().publishers)
      report.addresses = one.addresses.size();
  }
}

class DiscoveryTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    auto made = hosts::EmulatedNetwork::create(2);
    if (!made) GTEST_SKIP() << made.error().message;
    network_ = std::make_unique<hosts::EmulatedNetwork>(std::move(*made));
  }

  const hosts::NetworkNamespace& host(std::size_t number) const { return network_->host(number); }
  static std::string address(std::size_t number) { return hosts::EmulatedNetwork::address(number); }
  bool run_on(std::size_t number, const std::string& commands) const {
    const Result<void> done = host(number).run({"sh", "-ec", commands});
    return done ? true : (ADD_FAILURE() << done.error().message, false);
  }

  /// Connects eth1 of both hosts, in 10.78.0.0/24.
  void plug_in_another_cable() const {
    ASSERT_TRUE(run_on(0, "ip link add eth1 type veth peer name eth1 netns " + host(1).path() +
                              "; ip address add 10.78.0.1/24 dev eth1; ip link set dev eth1 up"));
    ASSERT_TRUE(run_on(1, "ip address add 10.78.0.2/24 dev eth1; ip link set dev eth1 up"));
  }

  /// Installs a BPF program that returns 2 for packets to drop. Skips the test and returns false if the
  /// kernel refuses.
  bool filter_what_is_sent(std::size_t number, const std::string& program) const {
    const Result<void> done = host(number).run(
        {"sh", "-ec",
         "tc qdisc add dev eth0 clsact; tc filter add dev eth0 egress bpf da bytecode '" + program + "'"});
    if (!done) skip("packets cannot be dropped here: " + done.error().message);
    return done.has_value();
  }

  static NodeOptions options(const DiscoverySettings& discovery = {}) {
    return {.discovery = discovery, .transport = TransportChoice::udp};
  }
  static DiscoverySettings only(std::vector<std::string> peers) {
    return {.peers = std::move(peers), .interfaces = {}, .multicast = false};
  }

 private:
  static void skip(const std::string& why) { GTEST_SKIP() << why; }

  std::unique_ptr<hosts::EmulatedNetwork> network_;
};

TEST_F(DiscoveryTest, NodesFindEachOtherByMulticast) {
  const NodeProcess publisher(host(0), options(), publish);
  const NodeProcess subscriber(host(1), options(), subscribe);
  EXPECT_TRUE(publisher.matches(1));
  EXPECT_TRUE(subscriber.matches(1));
  EXPECT_TRUE(subscriber.takes_samples());
}

TEST_F(DiscoveryTest, NodesThatNameEachOtherFindEachOtherWithoutMulticast) {
  const NodeProcess publisher(host(0), options(only({address(1)})), publish);
  const NodeProcess subscriber(host(1), options(only({address(0)})), subscribe);
  EXPECT_TRUE(subscriber.matches(1));
  EXPECT_TRUE(subscriber.takes_samples());
}

/// With several subscribers, one multicast datagram for all of them would be cheaper. Multicast must not be
/// used, because the datagram would not arrive.
TEST_F(DiscoveryTest, PeersThatMulticastDoesNotReachAreFoundAndTheirEndIsNoticed) {
  for (const std::size_t number : {0U, 1U}) {
    // The BPF program (ldb [0]; jeq 1, drop, pass) drops multicasts: the first byte of the destination's
    // hardware address is 1 for them.
    if (!filter_what_is_sent(number, "4,48 0 0 0,21 0 1 1,6 0 0 2,6 0 0 0")) return;
  }
  const DiscoverySettings here{.peers = {address(1)}, .interfaces = {}};
  const DiscoverySettings there{.peers = {address(0)}, .interfaces = {}};
  const NodeProcess publisher(host(0), options(here), publish);
  const NodeProcess near(host(0), options(here), subscribe);
  NodeProcess far(host(1), options(there), subscribe);
  const NodeProcess farther(host(1), options(there), subscribe);
  EXPECT_TRUE(near.takes_samples());
  EXPECT_TRUE(far.takes_samples());
  EXPECT_TRUE(farther.takes_samples());
  ASSERT_TRUE(publisher.matches(3));
  far.kill_now();
  EXPECT_TRUE(publisher.matches(2, 16s));
  EXPECT_TRUE(farther.takes_samples()) << "it has been heard of all the time";
}

TEST_F(DiscoveryTest, AFirewallThatDropsUnicastIsNamedInTheLogWithTheHostAndWhatToDo) {
  for (const std::size_t number : {0U, 1U}) {
    // The BPF program (ldb [0]; jset 1, pass, drop) lets only multicasts pass: the first byte of the
    // destination's hardware address is odd for them.
    if (!filter_what_is_sent(number, "4,48 0 0 0,69 1 0 1,6 0 0 2,6 0 0 0")) return;
  }
  const SharedWithChildren<std::atomic<bool>> reported;
  NodeOptions heedful = options();
  heedful.log = [&](LogLevel level, std::string_view line) {
    const auto says = [&](const std::string& text) { return line.find(text) != line.npos; };
    *reported = *reported || (level == LogLevel::warning && says("a process at " + address(0) + " has ") &&
                              says("let in all UDP of it, or name both hosts as DiscoverySettings::peers"));
  };
  const NodeProcess publisher(host(0), options(), publish);
  const NodeProcess subscriber(host(1), heedful, subscribe);
  EXPECT_TRUE(eventually([&] { return reported->load(); }));
  EXPECT_EQ(subscriber.report().matched, 0U);
}

/// Nodes with peers announce themselves less often than a node without peers expects.
TEST_F(DiscoveryTest, TheEndOfANodeThatHasPeersIsNoticedByOneThatHasNone) {
  const NodeProcess publisher(host(0), options(), publish);
  NodeProcess subscriber(host(1), options({.peers = {address(0)}, .interfaces = {}}), subscribe);
  ASSERT_TRUE(publisher.matches(1));
  subscriber.kill_now();
  EXPECT_TRUE(publisher.matches(0, 16s));
}

TEST_F(DiscoveryTest, TheLifeOfAnIdlePublisherThatHasPeersIsHeardOfByASubscriberThatHasNone) {
  const NodeProcess publisher(host(0), options({.peers = {address(1)}, .interfaces = {}}), promise_life);
  const NodeProcess subscriber(host(1), options(), expect_life);
  ASSERT_TRUE(subscriber.matches(1));
  EXPECT_FALSE(eventually([&] { return subscriber.report().liveliness_lost != 0; }, 4s));
}

TEST_F(DiscoveryTest, ANodeThatWaitsForAPublisherElsewhereThatIsSilentIsIdle) {
  const NodeProcess publisher(host(0), options(), publish_nothing);
  const NodeProcess subscriber(host(1), options(), wait_in_vain);
  ASSERT_TRUE(subscriber.matches(1, 20s));
  EXPECT_LT(subscriber.report().share_of_a_core, 0.005);
}

TEST_F(DiscoveryTest, WithoutMulticastNodesOfOneHostFindEachOther) {
  const NodeProcess publisher(host(0), options(only({})), publish);
  const NodeProcess subscriber(host(0), options(only({})), subscribe);
  const NodeProcess elsewhere(host(1), options(only({})), subscribe);
  EXPECT_TRUE(subscriber.matches(1));
  EXPECT_TRUE(subscriber.takes_samples());
  EXPECT_EQ(elsewhere.report().matched, 0U);
}

TEST_F(DiscoveryTest, NodesOfOtherDomainsAreNotFound) {
  NodeOptions other = options();
  other.domain = 7;
  const NodeProcess publisher(host(0), other, publish);
  const NodeProcess there(host(1), options(), subscribe);
  const NodeProcess here(host(1), other, subscribe);
  EXPECT_TRUE(here.matches(1));
  EXPECT_EQ(there.report().matched, 0U);
}

/// Tests in which both hosts lose a fifth of the packets that they send. The parameter is true if nodes are
/// discovered by multicast, and false if they are discovered by a list of peers.
class LossyDiscoveryTest : public DiscoveryTest, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    DiscoveryTest::SetUp();
    // The BPF program (ld rand; mod 5; jeq 0, drop, pass) drops a fifth of the packets.
    for (const std::size_t number : {0U, 1U}) {
      if (!IsSkipped()) filter_what_is_sent(number, "5,32 0 0 4294963256,148 0 0 5,21 1 0 0,6 0 0 0,6 0 0 2");
    }
  }
};

INSTANTIATE_TEST_SUITE_P(By, LossyDiscoveryTest, testing::Bool(),
                         [](const auto& param) { return param.param ? "Multicast" : "Peers"; });

TEST_P(LossyDiscoveryTest, NodesThatLoseAFifthOfAllPacketsAgreeOnMasks) {
  const auto settings = [&](std::size_t other) {
    return GetParam() ? DiscoverySettings{} : only({address(other)});
  };
  for (int round = 0; round < 5; ++round) {
    const NodeProcess publisher(host(0), options(settings(1)), publish);
    const NodeProcess subscriber(host(1), options(settings(0)), subscribe);
    EXPECT_TRUE(publisher.matches(1, hang_timeout)) << "round " << round;
    EXPECT_TRUE(subscriber.takes_samples(hang_timeout)) << "round " << round;
  }
}

TEST_F(DiscoveryTest, AKilledNodeIsNoticedWithinSeconds) {
  const NodeProcess publisher(host(0), options(), publish);
  NodeProcess subscriber(host(1), options(), subscribe);
  ASSERT_TRUE(subscriber.takes_samples());
  subscriber.kill_now();
  EXPECT_FALSE(publisher.matches(0, 3s)) << "that would be a short silence";
  EXPECT_TRUE(publisher.matches(0, 4s));
}

/// A firewall that allows only the ports of DDS drops heartbeats.
TEST_F(DiscoveryTest, NodesWhoseHeartbeatsAreDroppedKeepEachOtherAllTheSame) {
  const std::uint32_t domain = core::domain_id({}, std::getenv("ROS_DOMAIN_ID")).value();
  const std::string port = std::to_string(core::dds_config(domain, {}, "").value().heartbeat_port.value());
  // The BPF program (ldh the destination port; jeq, drop, pass) drops packets to the port of heartbeats.
  for (const std::size_t number : {0U, 1U}) {
    if (!filter_what_is_sent(number, "4,40 0 0 36,21 1 0 " + port + ",6 0 0 0,6 0 0 2")) return;
  }
  const NodeProcess publisher(host(0), options(), publish);
  NodeProcess subscriber(host(1), options(), subscribe);
  ASSERT_TRUE(publisher.matches(1));
  EXPECT_FALSE(publisher.matches(0, 10s)) << "longer than the lease";
  subscriber.kill_now();
  EXPECT_TRUE(publisher.matches(0, 12s)) << "the lease, and what the signs of life of others may take longer";
}

/// While the link is down, Cyclone keeps the participants, so that no participant has to be discovered
/// again.
TEST_F(DiscoveryTest, ANodeBehindALinkThatWasDownIsServedAgainAtOnce) {
  const NodeProcess publisher(host(0), options(), publish);
  const NodeProcess subscriber(host(1), options(), subscribe);
  ASSERT_TRUE(subscriber.takes_samples());
  ASSERT_TRUE(run_on(1, "ip link set dev eth0 down"));
  EXPECT_TRUE(publisher.matches(0, 7s));
  EXPECT_TRUE(subscriber.matches(0, 7s));
  ASSERT_TRUE(run_on(1, "ip link set dev eth0 up"));
  EXPECT_TRUE(publisher.matches(1, 3s));
  EXPECT_TRUE(subscriber.takes_samples(3s));
}

/// The default route of that host leads to another network, so the host prefers its address in that network.
TEST_F(DiscoveryTest, AHostWithTwoNetworksIsSentSamplesInTheOneThatLeadsThere) {
  ASSERT_TRUE(run_on(1,
                     "ip link add out type veth peer name far; ip link set dev out multicast off\n"
                     "ip address add 10.99.0.1/24 dev out; ip link set dev out up; ip link set dev far up\n"
                     "ip route add default via 10.99.0.2"));
  const NodeProcess publisher(host(0), options(), publish);
  const NodeProcess subscriber(host(1), options(), subscribe);
  EXPECT_TRUE(publisher.matches(1));
  EXPECT_TRUE(subscriber.takes_samples());
}

/// Each interface leads to a node that cannot be reached through the other interfaces.
TEST_F(DiscoveryTest, NodesAreFoundOnAllInterfacesThatAreListed) {
  plug_in_another_cable();
  const NodeProcess publisher(host(0), options({.interfaces = {"eth0", "10.78.0.1"}}), publish);
  const NodeProcess on_first(host(1), options({.interfaces = {"eth0"}}), subscribe);
  const NodeProcess on_second(host(1), options({.interfaces = {"eth1", "eth9", "fd09::/64"}}), subscribe);
  EXPECT_TRUE(on_first.takes_samples());
  EXPECT_TRUE(on_second.takes_samples());
  EXPECT_TRUE(publisher.matches(2));
}

TEST_F(DiscoveryTest, HostsThatHaveOnlyIPv6AreServedByThat) {
  for (const std::size_t number : {0U, 1U}) {
    ASSERT_TRUE(run_on(number, "ip address flush dev eth0; ip address add fd00::" +
                                   std::to_string(number + 1) + "/64 dev eth0 nodad"));
  }
  const NodeProcess publisher(host(0), options(), publish);
  const NodeProcess near(host(0), options(), subscribe);
  const NodeProcess far(host(1), options(), subscribe);
  EXPECT_TRUE(near.takes_samples());
  EXPECT_TRUE(far.takes_samples());
  EXPECT_TRUE(publisher.matches(2));
}

class FailoverTest : public DiscoveryTest, public testing::WithParamInterface<std::size_t> {};

INSTANTIATE_TEST_SUITE_P(Of, FailoverTest, testing::Values(0, 1), [](const auto& param) {
  return param.param == 0 ? "ThePublishersHost" : "TheSubscribersHost";
});

/// The second cable is the better path to the subscriber's host, while discovery uses the first cable.
TEST_P(FailoverTest, AReliableStreamGoesOnByAnotherInterfaceWithoutALoss) {
  plug_in_another_cable();
  ASSERT_TRUE(run_on(1, "ip route add default via 10.78.0.1"));
  const NodeProcess publisher(host(0), options(), publish_reliably);
  const NodeProcess subscriber(host(1), options(), subscribe_reliably);
  ASSERT_TRUE(subscriber.takes_samples());
  const auto goes_that_way = [&] {
    return host(0).run({"awk", R"($1 == "eth1:" {exit $10 < 200000})", "/proc/net/dev"}).has_value();
  };
  ASSERT_TRUE(eventually(goes_that_way, 5s)) << "the kernel takes a second to tell of a carrier";
  for (const char* change : {"down", "up"}) {
    ASSERT_TRUE(run_on(GetParam(), std::string("ip link set dev eth1 ") + change));
    EXPECT_TRUE(subscriber.takes_samples(2s)) << change;
  }
  EXPECT_EQ(subscriber.report().out_of_order, 0U);
  EXPECT_EQ(publisher.report().matched, 1U);
}

/// The subscriber's host sees no change of its own interfaces, because a switch is between the hosts.
TEST_F(DiscoveryTest, AReliableStreamOutlivesTheInterfaceOfThePublishersDiscovery) {
  plug_in_another_cable();
  const DiscoverySettings both{.interfaces = {"eth0", "eth1"}};
  const NodeProcess publisher(host(0), options(both), publish_reliably);
  const NodeProcess subscriber(host(1), options(both), subscribe_reliably);
  ASSERT_TRUE(subscriber.takes_samples());
  for (const std::string change : {"eth0 down", "eth0 up", "eth1 down"}) {
    ASSERT_TRUE(run_on(0, "ip link set dev " + change));
    EXPECT_TRUE(subscriber.takes_samples(2s)) << change;
    if (change == "eth0 up") {
      const auto both_are_known = [&] { return subscriber.report().addresses >= 2; };
      EXPECT_TRUE(eventually(both_are_known, 5s)) << "nodes look at their interfaces five times a second";
    }
  }
  EXPECT_EQ(subscriber.report().out_of_order, 0U);
  EXPECT_EQ(publisher.report().matched, 1U);
}

}  // namespace
}  // namespace sft::test
