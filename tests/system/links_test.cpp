// Nodes on robots whose network interfaces appear late, change their addresses, lose their cables and are
// replaced. Users list the interfaces correctly, wrongly, or not at all.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <unistd.h>

#include <sft/sft.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <vector>

#include "core/discovery/timing.h"
#include "core/platform/file_descriptor.h"
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
  std::atomic<bool> opened{false};
  std::atomic<bool> may_close_files{false};
  std::atomic<std::size_t> matched{0};
  std::atomic<bool> unanswered{false};  ///< the status of the publisher says that its reader does not answer
  std::atomic<std::uint64_t> taken{0};
  std::array<std::atomic<char>, 400> discovery{};  ///< the text of NodeStatus::discovery

  void add(const std::string& text) {
    for (std::size_t i = 0; i < discovery.size(); ++i) discovery[i] = i < text.size() ? text[i] : '\0';
    opened = true;
  }
  std::string reported() const {
    std::string text;
    for (const auto& letter : discovery) {
      if (letter == '\0') break;
      text += letter;
    }
    return text;
  }
};

class NodeProcess : public NodeProcessWith<Report> {
 public:
  using NodeProcessWith::NodeProcessWith;

  bool is_open() const {
    return eventually([&] { return report().opened.load(); }, hang_timeout);
  }
  bool takes_samples() const {
    const std::uint64_t before = report().taken;
    return eventually([&] { return report().taken > before + 10; }, hang_timeout);
  }
  bool says(const std::string& text) const {
    return eventually([&] { return report().reported().find(text) != std::string::npos; }, hang_timeout);
  }
};

constexpr std::chrono::milliseconds between_samples{5};
/// The number of samples that are due within the lease of a participant.
constexpr std::uint64_t samples_of_a_lease = core::Timing{}.lease / between_samples;

void publish(Node& node, Report& report) {
  auto publisher = node.publisher<PointCloud2>("points").value();
  for (std::uint32_t i = 1;; ++i) {
    std::size_t served = 0;
    bool unanswered = false;
    for (const auto& reader : publisher.status().readers) {
      served += reader.served ? 1 : 0;
      unanswered =
          unanswered || reader.reason.find("the host did not answer at 10.0.0.2") != std::string::npos;
    }
    report.matched = served;
    report.unanswered = unanswered;
    report.add(node.status().discovery);
    publisher.publish({.height = i});
    poll(nullptr, 0, between_samples.count());
  }
}

void subscribe(Node& node, Report& report) {
  auto subscriber = node.subscriber<PointCloud2, F::height | F::width>("points").value();
  for (;;) {
    std::size_t matched = 0;
    for (const auto& writer : subscriber.status().writers) matched += writer.matched && writer.alive ? 1 : 0;
    report.matched = matched;
    report.add(node.status().discovery);
    if (subscriber.wait(5ms) && subscriber.take()) ++report.taken;
  }
}

/// Two hosts with only a loopback interface, and a separate network namespace with switches.
class LinksTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    for (int i = 0; i < 3; ++i) {
      auto made = hosts::NetworkNamespace::create();
      if (!made) GTEST_SKIP() << made.error().message;
      spaces_.push_back(std::move(*made));
    }
    for (const std::size_t host : {robot, laptop}) ASSERT_TRUE(run(host, "ip link set lo up"));
    for (const char* name : {"first", "second", "third"}) {
      ASSERT_TRUE(run(room, "ip link add " + std::string(name) +
                                " type bridge stp_state 0 mcast_snooping 0 && ip link set " + name + " up"));
    }
  }

  static constexpr std::size_t robot = 0, laptop = 1, room = 2;

  const hosts::NetworkNamespace& host(std::size_t number) const { return spaces_[number]; }
  bool run(std::size_t where, const std::string& commands) const {
    const Result<void> done = host(where).run({"sh", "-ec", commands});
    return done ? true : (ADD_FAILURE() << done.error().message, false);
  }
  /// Gives a host an interface that is connected to one of the switches. The port of the switch is named
  /// "<interface>_<host>".
  void plug_in(std::size_t where, const std::string& interface, const std::string& address,
               const std::string& network_switch = "first") const {
    const std::string port = interface + "_" + std::to_string(where);
    ASSERT_TRUE(run(room, "ip link add " + port + " type veth peer name " + interface + " netns " +
                              host(where).path() + " && ip link set " + port + " master " + network_switch +
                              " up"));
    ASSERT_TRUE(run(where, "ip address add " + address + "/24 dev " + interface + " && ip link set " +
                               interface + " up"));
  }

  static NodeOptions options(std::vector<std::string> interfaces = {}) {
    return {.discovery = {.interfaces = std::move(interfaces)}, .transport = TransportChoice::udp};
  }

  /// Waits until samples arrive (again), and prints the time that this took.
  static testing::AssertionResult comes_soon(const NodeProcess& subscriber) {
    const auto begin = std::chrono::steady_clock::now();
    const bool came = subscriber.takes_samples();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    std::printf("samples came after %.2f s\n", took.count());
    return came ? testing::AssertionSuccess() : testing::AssertionFailure() << subscriber.report().reported();
  }
  /// Waits until no more samples arrive.
  static bool falls_silent(const NodeProcess& subscriber) {
    return eventually(
        [&, last = std::uint64_t{0}]() mutable {
          const std::uint64_t before = std::exchange(last, subscriber.report().taken.load());
          poll(nullptr, 0, 100);
          return before == subscriber.report().taken;
        },
        hang_timeout);
  }

 private:
  std::vector<hosts::NetworkNamespace> spaces_;
};

/// A robot, and the interfaces that its user lists. Its interface "huc" leads to the laptop.
struct Cell {
  const char* name;
  std::vector<std::string> listed;
  bool has_another_network = false;
};

class RobotsInterfaces : public LinksTest, public testing::WithParamInterface<std::tuple<Cell, bool>> {};

INSTANTIATE_TEST_SUITE_P(
    Each, RobotsInterfaces,
    testing::Combine(testing::Values(Cell{"NothingListed", {}}, Cell{"Listed", {"huc"}},
                                     Cell{"ListedWithLo", {"lo", "huc"}},
                                     Cell{"ListedBeforeLo", {"huc", "lo"}},
                                     Cell{"BesideAnotherNetwork", {}, true},
                                     Cell{"ListedWithAnotherNetwork", {"lan0", "huc"}, true},
                                     Cell{"ListedBesideATypo", {"dumm0", "huc"}}),
                     testing::Bool()),
    [](const auto& param) {
      return std::string(std::get<0>(param.param).name) + (std::get<1>(param.param) ? "Late" : "AtStart");
    });

TEST_P(RobotsInterfaces, AreUsedWhetherTheyAreThereOrComeLate) {
  const auto& [cell, late] = GetParam();
  if (cell.has_another_network) plug_in(robot, "lan0", "10.1.0.1", "second");
  plug_in(laptop, "huc", "10.0.0.2");
  if (!late) plug_in(robot, "huc", "10.0.0.1");
  const NodeProcess publisher(host(robot), options(cell.listed), publish);
  ASSERT_TRUE(publisher.is_open());
  const NodeProcess subscriber(host(laptop), options(), subscribe);
  if (late) {
    ASSERT_TRUE(subscriber.is_open());
    if (!cell.has_another_network) {
      EXPECT_TRUE(publisher.says("no network yet: other hosts are looked for as soon as an interface is up"));
    }
    EXPECT_TRUE(cell.listed.empty() || publisher.says("huc is not there"));
    plug_in(robot, "huc", "10.0.0.1");
  }
  EXPECT_TRUE(comes_soon(subscriber));
  EXPECT_TRUE(publisher.says("huc (10.0.0.1)")) << publisher.report().reported();
  EXPECT_EQ(publisher.report().reported().find("huc is not there"), std::string::npos);
  if (cell.listed == std::vector<std::string>{"dumm0", "huc"}) {
    EXPECT_TRUE(publisher.says("dumm0 is not there"));
  }
}

/// Tests with a publisher on the robot and a subscriber on the laptop, whose network changes while samples
/// are sent.
class ChangesOfNetwork : public LinksTest {
 protected:
  void SetUp() override {
    LinksTest::SetUp();
    if (IsSkipped()) return;
    plug_in(robot, "lan0", "10.0.0.1");
    plug_in(laptop, "lan0", "10.0.0.2");
    publisher_ = std::make_unique<NodeProcess>(host(robot), options(), publish);
    subscriber_ = std::make_unique<NodeProcess>(host(laptop), options(), subscribe);
    ASSERT_TRUE(subscriber().takes_samples());
  }
  NodeProcess& publisher() { return *publisher_; }
  NodeProcess& subscriber() { return *subscriber_; }
  /// Returns true if the robot has sent more packets by `interface` than by `other`.
  bool goes_by(const std::string& interface, const std::string& other) const {
    return host(robot)
        .run({"sh", "-ec",
              "sent() { awk -v of=\"$1:\" '$1 == of {print $11}' /proc/net/dev; }\n"
              "before=$(sent \"$0\") other_before=$(sent \"$1\"); sleep 0.3\n"
              "[ $(($(sent \"$0\") - before)) -gt $(($(sent \"$1\") - other_before)) ]",
              interface, other})
        .has_value();
  }
  void take_address(std::size_t where, const std::string& before, const std::string& after) const {
    ASSERT_TRUE(
        run(where, "ip address del " + before + "/24 dev lan0; ip address add " + after + "/24 dev lan0"));
  }

 private:
  std::unique_ptr<NodeProcess> publisher_;
  std::unique_ptr<NodeProcess> subscriber_;
};

TEST_F(ChangesOfNetwork, OfBothAddressesByDhcp) {
  take_address(robot, "10.0.0.1", "10.7.0.11");
  take_address(laptop, "10.0.0.2", "10.7.0.12");
  EXPECT_TRUE(comes_soon(subscriber()));
  EXPECT_TRUE(publisher().says("lan0 (10.7.0.11)"));
}

TEST_F(ChangesOfNetwork, OfTheAddressOfThePublisher) {
  take_address(robot, "10.0.0.1", "10.0.0.11");
  EXPECT_TRUE(comes_soon(subscriber()));
}

TEST_F(ChangesOfNetwork, OfTheAddressOfTheSubscriber) {
  take_address(laptop, "10.0.0.2", "10.0.0.12");
  EXPECT_TRUE(falls_silent(subscriber()));
  EXPECT_TRUE(comes_soon(subscriber()));
}

TEST_F(ChangesOfNetwork, OfTheCardByAnotherOne) {
  ASSERT_TRUE(run(robot, "ip link delete lan0"));
  EXPECT_TRUE(falls_silent(subscriber()));
  plug_in(robot, "lan0", "10.0.0.1");  // the new interface has another hardware address
  EXPECT_TRUE(comes_soon(subscriber()));
}

TEST_F(ChangesOfNetwork, ByACableThatIsPulledAndPluggedInAgain) {
  ASSERT_TRUE(run(room, "ip link set lan0_0 down"));
  EXPECT_TRUE(falls_silent(subscriber()));
  ASSERT_TRUE(run(room, "ip link set lan0_0 up"));
  EXPECT_TRUE(comes_soon(subscriber()));
}

TEST_F(ChangesOfNetwork, ByASwitchThatReboots) {
  ASSERT_TRUE(run(room, "ip link set first down"));
  EXPECT_TRUE(eventually([&] { return publisher().report().matched == 0; }, hang_timeout));
  ASSERT_TRUE(run(room, "ip link set first up"));
  EXPECT_TRUE(comes_soon(subscriber()));
}

TEST_F(ChangesOfNetwork, ByASecondNetworkThatOutlivesTheFirst) {
  plug_in(robot, "lan1", "10.1.0.1", "second");
  plug_in(laptop, "lan1", "10.1.0.2", "second");
  EXPECT_TRUE(publisher().says("lan1 (10.1.0.1)"));
  EXPECT_TRUE(subscriber().says("lan1 (10.1.0.2)"));
  ASSERT_TRUE(run(robot, "ip link set lan0 down"));
  EXPECT_TRUE(falls_silent(subscriber()) || subscriber().report().taken > 0);
  EXPECT_TRUE(comes_soon(subscriber()));
}

/// Neither host detects that one network is interrupted, and heartbeats continue to arrive by the other
/// network. Samples must then use the other network, too.
TEST_F(ChangesOfNetwork, ByACutThatNobodySeesBesideAnotherNetwork) {
  plug_in(robot, "lan1", "10.1.0.1", "second");
  plug_in(laptop, "lan1", "10.1.0.2", "second");
  EXPECT_TRUE(publisher().says("lan1 (10.1.0.1)"));
  EXPECT_TRUE(subscriber().says("lan1 (10.1.0.2)"));
  ASSERT_TRUE(subscriber().takes_samples());
  const std::string cut = goes_by("lan0", "lan1") ? "first" : "second";
  ASSERT_TRUE(run(room, "ip link set " + cut + " down"));
  EXPECT_TRUE(falls_silent(subscriber()));
  EXPECT_TRUE(comes_soon(subscriber()));
  const std::uint64_t before = subscriber().report().taken;
  EXPECT_TRUE(
      eventually([&] { return subscriber().report().taken > before + samples_of_a_lease; }, hang_timeout))
      << "samples went back to the network that is cut";
  EXPECT_EQ(publisher().report().matched, 1U);
}

/// A network that works in one direction only, as behind a firewall. The parameter is the host of which
/// nothing arrives any more.
class OneWayCut : public ChangesOfNetwork, public testing::WithParamInterface<std::size_t> {
 protected:
  void cut() const {
    ASSERT_TRUE(run(room,
                    "nft add table bridge cut; "
                    "nft add chain bridge cut f '{ type filter hook forward priority 0; }'; "
                    "nft add rule bridge cut f iifname lan0_" +
                        std::to_string(GetParam()) + " ip protocol udp drop"));
  }
  void mend() const { ASSERT_TRUE(run(room, "nft delete table bridge cut")); }
};

INSTANTIATE_TEST_SUITE_P(Of, OneWayCut, testing::Values(0, 1), [](const auto& param) {
  return param.param == 0 ? "ThePublisher" : "TheSubscriber";
});

TEST_P(OneWayCut, IsNoticedAndSamplesComeSoonAfterIt) {
  cut();
  EXPECT_TRUE(falls_silent(subscriber()));
  if (GetParam() == robot) {
    EXPECT_TRUE(eventually([&] { return publisher().report().unanswered.load(); }, hang_timeout));
    EXPECT_EQ(publisher().report().matched, 1U) << "the subscriber is heard";
    EXPECT_TRUE(eventually([&] { return subscriber().report().matched == 0; }, hang_timeout));
  } else {
    EXPECT_TRUE(eventually([&] { return publisher().report().matched == 0; }, hang_timeout));
  }
  mend();
  EXPECT_TRUE(comes_soon(subscriber()));
  EXPECT_TRUE(eventually([&] { return !publisher().report().unanswered; }, hang_timeout));
}

TEST_F(LinksTest, AVpnThatComesUpIsUsed) {
  plug_in(robot, "lan0", "10.0.0.1", "first");
  plug_in(laptop, "lan0", "10.1.0.2", "second");
  const NodeProcess publisher(host(robot), options(), publish);
  const NodeProcess subscriber(host(laptop), options(), subscribe);
  ASSERT_TRUE(publisher.is_open());
  ASSERT_TRUE(subscriber.is_open());
  EXPECT_EQ(subscriber.report().matched, 0U);
  plug_in(robot, "vpn", "10.8.0.1", "third");
  plug_in(laptop, "vpn", "10.8.0.2", "third");
  EXPECT_TRUE(comes_soon(subscriber));
}

TEST_F(LinksTest, NodesOfOneHostFindEachOtherWhateverItsNetworkDoes) {
  const NodeProcess publisher(host(robot), options({"huc"}), publish);
  const NodeProcess subscriber(host(robot), options({"huc"}), subscribe);
  EXPECT_TRUE(comes_soon(subscriber));
  plug_in(robot, "huc", "10.0.0.1");
  EXPECT_TRUE(publisher.says("huc (10.0.0.1)"));
  ASSERT_TRUE(run(robot, "ip link delete huc"));
  EXPECT_TRUE(publisher.says("huc is not there"));
  EXPECT_TRUE(comes_soon(subscriber));
  EXPECT_EQ(publisher.report().matched, 1U);
}

/// Publishes while open files occupy all descriptor numbers that select(2) can handle. The program closes
/// these files when the test requests it.
void publish_beside_many_files(Node& node, Report& report) {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit = {.rlim_cur = 4096, .rlim_max = std::max<rlim_t>(limit.rlim_max, 4096)};
  setrlimit(RLIMIT_NOFILE, &limit);
  std::vector<core::FileDescriptor> files;
  while (files.size() < 2 * FD_SETSIZE) files.emplace_back(open("/dev/null", O_RDONLY));
  while (!report.may_close_files) {
    report.add(node.status().discovery);
    poll(nullptr, 0, 5);
  }
  files.clear();
  publish(node, report);
}

TEST_F(LinksTest, AnInterfaceThatComesWhileAProgramHasManyFilesIsUsedOnceItHasFewer) {
  const NodeProcess publisher(host(robot), options(), publish_beside_many_files);
  ASSERT_TRUE(publisher.is_open());
  plug_in(laptop, "huc", "10.0.0.2");
  const NodeProcess subscriber(host(laptop), options(), subscribe);
  plug_in(robot, "huc", "10.0.0.1");
  EXPECT_TRUE(publisher.says("file descriptors with numbers below 1024")) << publisher.report().reported();
  publisher.report().may_close_files = true;
  EXPECT_TRUE(comes_soon(subscriber));
}

TEST_F(LinksTest, WithoutAnyInterfaceANodeSaysSo) {
  ASSERT_TRUE(run(robot, "ip link set lo down"));
  const NodeProcess::Role none = [](Node&, Report&) { pause(); };
  testing::internal::CaptureStderr();
  const NodeProcess node(host(robot), options(), none);
  ASSERT_TRUE(eventually([&] { return node.report().failed.load(); }, hang_timeout));
  EXPECT_NE(testing::internal::GetCapturedStderr().find("no network interface is up"), std::string::npos);
}

}  // namespace
}  // namespace sft::test
