// Hosts behind links and routers that carry packets of different lengths, over IPv4 and IPv6.
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

#include "tests/support/isolated_host.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "udp_transport/io/interfaces.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::make_image;
using test::Publisher;
using test::Subscriber;

void run_all(const std::string& commands) {
  ASSERT_EQ(std::system(("sh -ec '" + commands + "'").c_str()), 0) << commands;
}

/// Records the length of the longest datagram that arrives.
class LongestSoFar final : public test::PassingReceiver {
 public:
  LongestSoFar(std::unique_ptr<DatagramReceiver> inner, std::atomic<std::size_t>& longest)
      : PassingReceiver(std::move(inner)), longest_(longest) {}

 private:
  void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept override {
    longest_ = std::max(longest_.load(), bytes.size());
    pass_on(bytes, from);
  }

  std::atomic<std::size_t>& longest_;
};

/// Makes addresses usable at once, without detection of duplicates.
constexpr const char* set_up =
    "ip link set lo up; for f in /proc/sys/net/ipv6/conf/*/accept_dad; do echo 0 > $f; done";

/// A host with a network namespace of its own, and a transport if a test opens one.
class Host {
 public:
  Host() {
    keeper_ = std::thread([this] {
      own_ = ::unshare(CLONE_NEWNET) == 0 && std::system(set_up) == 0;
      thread_id_ = ::gettid();
      std::unique_lock lock(mutex_);
      for (;;) {
        idle_.notify_all();
        wanted_.wait(lock, [this] { return gone_ || task_; });
        if (gone_) return;
        std::exchange(task_, nullptr)();
      }
    });
    while (thread_id_ == 0) std::this_thread::yield();
  }
  ~Host() {
    {
      const std::scoped_lock lock(mutex_);
      gone_ = true;
    }
    wanted_.notify_all();
    keeper_.join();
  }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  bool is_own() const { return own_; }
  /// Returns the name of the namespace for `ip link ... netns`.
  std::string name() const {
    return "/proc/" + std::to_string(::getpid()) + "/task/" + std::to_string(thread_id_) + "/ns/net";
  }
  /// Runs the task in the namespace of that host, and waits for its end.
  void here(std::function<void()> task) {
    std::unique_lock lock(mutex_);
    task_ = std::move(task);
    wanted_.notify_all();
    idle_.wait(lock, [this] { return !task_; });
  }
  void run_here(const std::string& commands) {
    here([&] { run_all(commands); });
  }

  core::Network& open_transport(Backend backend) {
    here([&] {
      transport_ = open_udp_transport({.backend = backend}, test::make_pool(), [this](DatagramIo io) {
                     io.receiver = std::make_unique<LongestSoFar>(std::move(io.receiver), longest_);
                     return io;
                   }).value();
    });
    return *transport_;
  }
  core::UdpAddress at(const core::IpAddress& ip) const {
    core::UdpAddress address = transport_->addresses().at(0);
    address.ip = ip;
    return address;
  }
  /// Returns the length of the longest datagram since the last call, in bytes.
  std::size_t longest() { return longest_.exchange(0); }

 private:
  std::thread keeper_;
  std::atomic<pid_t> thread_id_{0};
  std::atomic<bool> own_{false};
  std::mutex mutex_;
  std::condition_variable wanted_, idle_;
  std::function<void()> task_;
  bool gone_ = false;
  std::atomic<std::size_t> longest_{0};
  std::unique_ptr<core::Network> transport_;
};

enum class Family : std::uint8_t { ipv4, ipv6 };

class PathsTest : public testing::TestWithParam<Family> {
 protected:
  void SetUp() override {
    if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
    if (!Host().is_own()) GTEST_SKIP() << "a second host cannot be had here";
  }
  void TearDown() override { std::system("for l in out1 out2; do ip link del $l; done 2> /dev/null"); }

  static bool ipv6() { return GetParam() == Family::ipv6; }
  /// Returns the address of host `number` in network `net`.
  static std::string address(unsigned net, unsigned number) {
    return (ipv6() ? "fd0" : "10.20.") + std::to_string(net) + (ipv6() ? "::" : ".") + std::to_string(number);
  }
  static core::IpAddress ip(unsigned net, unsigned number) {
    return core::parse_ip_address(address(net, number)).value();
  }
  static std::string bits() { return ipv6() ? "/64" : "/24"; }
  static std::string add_address(unsigned net, unsigned number, const std::string& device) {
    return "ip address add " + address(net, number) + bits() + " dev " + device + (ipv6() ? " nodad" : "");
  }
  static std::size_t payload(std::size_t mtu) { return mtu - (ipv6() ? 48 : 28); }

  /// Makes a cable from the test's own host to `host`. The cable is network `net`, in which the test's host
  /// is number 1. Batches are cut into frames before they reach the cable.
  static void plug_in(Host& host, unsigned net, unsigned mtu) {
    const std::string number = std::to_string(net), out = "out" + number, mtus = std::to_string(mtu);
    run_all("ip link add " + out + " mtu " + mtus + " type veth peer name in0 mtu " + mtus + " netns " +
            host.name() + "; " + add_address(net, 1, out) + "; ip link set " + out + " up; ethtool -K " +
            out + " tx-udp-segmentation off > /dev/null");
    host.run_here(add_address(net, 2, "in0") + "; ip link set in0 up");
  }

  /// Makes another cable, from the router to a host behind it. The cable is network 2, in which the router is
  /// number 1.
  static void put_behind(Host& router, Host& far, unsigned mtu) {
    const std::string mtus = std::to_string(mtu);
    router.run_here("ip link add r1 mtu " + mtus + " type veth peer name in0 mtu " + mtus + " netns " +
                    far.name() + "; " + add_address(2, 1, "r1") +
                    "; ip link set r1 up; echo 1 > /proc/sys/net/" +
                    (ipv6() ? "ipv6/conf/all/forwarding" : "ipv4/ip_forward"));
    far.run_here(add_address(2, 2, "in0") + "; ip link set in0 up; ip route add default via " +
                 address(2, 1));
    run_all("ip route add " + address(2, 0) + bits() + " via " + address(1, 2));
  }
  /// Makes the router drop longer packets without an error from now on, as some tunnels do. The sending host
  /// cuts batches of datagrams into packets before they reach the router.
  static void drop_longer_than(unsigned bytes, Host& router) {
    router.run_here(
        "nft add table inet silent; nft add chain inet silent f \"{ type filter hook forward "
        "priority 0; }\"; nft add rule inet silent f meta length \\> " +
        std::to_string(bytes) + " drop");
  }

  std::unique_ptr<core::Network> open() {
    return open_udp_transport({.backend = Backend::sockets}, test::make_pool()).value();
  }
};

INSTANTIATE_TEST_SUITE_P(Over, PathsTest, testing::Values(Family::ipv4, Family::ipv6),
                         [](const auto& param) { return param.param == Family::ipv4 ? "IPv4" : "IPv6"; });

TEST_P(PathsTest, SendsEachHostTheLongestDatagramsThatItsPathTakes) {
  Host jumbo, usual;
  plug_in(jumbo, 1, 9000);
  plug_in(usual, 2, 1500);
  Subscriber of_jumbo(jumbo.open_transport(Backend::io_uring), {"*"}),
      of_usual(usual.open_transport(Backend::sockets), {"*"});
  const auto near = open();
  Publisher publisher(*near);
  of_jumbo.listen_reliably_to(publisher.id());
  of_usual.listen_reliably_to(publisher.id());
  publisher.serve({{jumbo.at(ip(1, 2)), "*", true}, {usual.at(ip(2, 2)), "*", true}});
  publisher.publish(make_image(300'000));
  EXPECT_EQ(of_jumbo.await(1).size(), 1U);
  EXPECT_EQ(of_usual.await(1).size(), 1U);
  EXPECT_EQ(jumbo.longest(), payload(9000));
  EXPECT_EQ(usual.longest(), payload(1500));

  // First the link gets a shorter limit. A sample that the system refuses is cut again and not lost. Then the
  // link gets the longer limit again.
  run_all("ip link set out1 mtu 1280");
  publisher.publish(make_image(300'000));
  EXPECT_EQ(of_jumbo.await(2).size(), 2U);
  EXPECT_EQ(jumbo.longest(), payload(1280));
  run_all("ip link set out1 mtu 9000");
  EXPECT_TRUE(near->network_changed());
  near->poll(std::chrono::steady_clock::now());
  publisher.publish(make_image(300'000));
  EXPECT_EQ(of_jumbo.await(3).size(), 3U);
  EXPECT_EQ(jumbo.longest(), payload(9000));
}

class IPv4PathsTest : public PathsTest {};
INSTANTIATE_TEST_SUITE_P(Over, IPv4PathsTest, testing::Values(Family::ipv4),
                         [](const auto&) { return "IPv4"; });

TEST_P(IPv4PathsTest, LeadToWhereIPv6IsSwitchedOff) {
  Host far;
  far.run_here("for f in /proc/sys/net/ipv6/conf/*/disable_ipv6; do echo 1 > $f; done");
  plug_in(far, 1, 1500);
  core::Network& there = far.open_transport(Backend::io_uring);
  Subscriber subscriber(there, {"*"});
  far.here([&] { EXPECT_EQ(there.addresses().size(), 1U); });
  const auto near = open();
  Publisher publisher(*near);
  subscriber.listen_reliably_to(publisher.id());
  publisher.serve({{far.at(ip(1, 2)), "*", true}});
  publisher.publish(make_image(300'000));
  EXPECT_EQ(subscriber.await(1).size(), 1U);
}

TEST_P(PathsTest, LearnsFromARouterWhatThePathBehindItTakes) {
  Host router, far;
  plug_in(router, 1, 9000);
  put_behind(router, far, 1400);
  Subscriber subscriber(far.open_transport(Backend::io_uring), {"*"});
  const auto near = open();
  Publisher publisher(*near);
  subscriber.listen_reliably_to(publisher.id());
  publisher.serve({{far.at(ip(2, 2)), "*", true}});
  for (std::size_t n = 1; n <= 3; ++n) {
    publisher.publish(make_image(300'000));
    ASSERT_EQ(subscriber.await(n).size(), n);
  }
  EXPECT_EQ(far.longest(), payload(1400));
}

/// The far end of the cable takes shorter packets than the near end, and drops longer ones silently.
TEST_P(PathsTest, FindsOutReliablyWhatAPathTakesThatDropsLongerOnesSilently) {
  Host far;
  plug_in(far, 1, 9000);
  far.run_here("ip link set in0 mtu 1450");
  Subscriber subscriber(far.open_transport(Backend::io_uring), {"*"});
  const auto near = open();
  Publisher publisher(*near);
  subscriber.listen_reliably_to(publisher.id());
  publisher.serve({{far.at(ip(1, 2)), "*", true}});
  const auto begin = std::chrono::steady_clock::now();
  publisher.publish(make_image(30'000));
  ASSERT_EQ(subscriber.await(1).size(), 1U);
  EXPECT_EQ(far.longest(), payload(1280));
  std::size_t longest = 0;
  for (std::size_t n = 2; n <= 500 && longest != payload(1450); ++n) {
    near->poll(begin + n * 2s);
    publisher.publish(make_image(30'000));
    ASSERT_EQ(subscriber.await(n).size(), n);
    longest = far.longest();
  }
  EXPECT_EQ(longest, payload(1450));
}

/// Best-effort samples are not sent again.
TEST_P(PathsTest, LosesNoneOfManySmallSamplesWhereALinkTakesLessFromNowOn) {
  Host far;
  plug_in(far, 1, 9000);
  Subscriber subscriber(far.open_transport(Backend::io_uring), {"*"}, 1000);
  const auto near = open();
  Publisher publisher(*near);
  subscriber.listen_to(publisher.id());
  publisher.serve({{far.at(ip(1, 2)), "*"}});
  for (std::size_t n = 1; n <= 3; ++n) {
    if (n == 2) run_all("ip link set out1 mtu 1300");
    core::Batch batch = publisher.port().batch(core::BatchTimeout::fresh);
    for (int i = 0; i < 100; ++i) {
      const core::SampleHandle sample = publisher.make(make_image(40));
      sample->source_stamp_ns = 7;
      publisher.port().send(sample);
    }
    EXPECT_EQ(std::move(batch).flush(), 0U);
    EXPECT_EQ(subscriber.await(100 * n).size(), 100 * n);
  }
}

/// Bytes of data. The samples fit into one datagram, just do not fit, or take a few or many datagrams.
constexpr std::size_t all_sizes[] = {100, 1300, 1400, 9000, 1'600'000};

TEST_P(PathsTest, BringReliableSamplesOfEverySizeBothWaysWhereARouterDropsLongPacketsSilently) {
  Host router, far;
  plug_in(router, 1, 9000);
  put_behind(router, far, 1500);
  drop_longer_than(1280, router);
  for (const bool offload : {false, true}) {
    far.run_here(std::string("ethtool -K in0 tx-udp-segmentation off gro ") + (offload ? "on" : "off"));
    for (const std::size_t bytes : all_sizes) {
      core::Network& there = far.open_transport(offload ? Backend::io_uring : Backend::sockets);
      const auto near = open();
      Subscriber far_one(there, {"*"}), near_one(*near, {"*"});
      Publisher to_far(*near, 7), to_near(there, 8);
      far_one.listen_reliably_to(to_far.id());
      near_one.listen_reliably_to(to_near.id());
      core::UdpAddress here = near->addresses().at(0);
      here.ip = ip(1, 1);
      to_far.serve({{far.at(ip(2, 2)), "*", true}});
      far.here([&] { to_near.serve({{here, "*", true}}); });
      for (std::size_t n = 1; n <= 3; ++n) {
        to_far.publish(make_image(bytes));
        to_near.publish(make_image(bytes));
        ASSERT_EQ(far_one.await(n).size(), n) << bytes;
        ASSERT_EQ(near_one.await(n).size(), n) << bytes;
      }
    }
  }
}

/// Samples are lost until the sender knows the longest length that the path carries. Later samples arrive.
TEST_P(PathsTest, BringBestEffortSamplesOfEverySizeThereAndNameTheLimit) {
  Host router, far;
  plug_in(router, 1, 9000);
  put_behind(router, far, 1500);
  drop_longer_than(1280, router);
  for (const std::size_t bytes : all_sizes) {
    Subscriber subscriber(far.open_transport(Backend::io_uring), {"*"});
    const auto near = open();
    Publisher publisher(*near);
    subscriber.listen_to(publisher.id());
    publisher.serve({{far.at(ip(2, 2)), "*"}});
    std::size_t came = 0;
    const auto another_one_comes = [&] {
      publisher.publish(make_image(bytes));
      const std::size_t before = std::exchange(came, subscriber.await(came + 1, 0s).size());
      return came > before;
    };
    for (int i = 0; i < 5; ++i)
      EXPECT_TRUE(test::eventually(another_one_comes, test::hang_timeout, 20ms)) << bytes;
    const std::string limit = "datagrams longer than " + std::to_string(payload(1280)) +
                              " bytes do not arrive at '" + address(2, 2) +
                              "': samples go there in shorter ones";
    EXPECT_EQ(publisher.port().path_trouble(1), bytes == 100 ? "" : limit) << bytes;
  }
}

/// Publishes samples of several sizes to a host, reliably or not, and expects each size to arrive.
void expect_every_size(core::Network& near, Host& far, const core::IpAddress& ip) {
  for (const bool reliable : {true, false}) {
    for (const std::size_t bytes : {100U, 700U, 9000U, 200'000U}) {
      Subscriber subscriber(far.open_transport(Backend::sockets), {"*"});
      Publisher publisher(near, 2 * bytes + (reliable ? 1 : 0));
      if (reliable) subscriber.listen_reliably_to(publisher.id());
      if (!reliable) subscriber.listen_to(publisher.id());
      publisher.serve({{far.at(ip), "*", reliable}});
      std::size_t published = 0;
      EXPECT_TRUE(test::eventually(
          [&] {
            publisher.publish(make_image(bytes));
            ++published;
            return subscriber.await(3, 0s).size() >= 3;
          },
          test::hang_timeout, 20ms))
          << bytes << (reliable ? " reliably" : "");
      if (reliable) {
        EXPECT_EQ(subscriber.await(published).size(), published) << bytes;
      }
    }
  }
}

TEST_P(IPv4PathsTest, BringSamplesOfEverySizeWhereARouterSilentlyDropsPacketsOfMoreThan576Bytes) {
  Host router, far;
  plug_in(router, 1, 1500);
  put_behind(router, far, 1500);
  drop_longer_than(576, router);
  const auto near = open();
  expect_every_size(*near, far, ip(2, 2));
}

/// The kernel divides the datagrams, because SFT cuts none into so short ones.
TEST_P(IPv4PathsTest, BringSamplesOfEverySizeOverALinkThatCarriesLessThanTheShortestDatagrams) {
  Host far;
  plug_in(far, 1, 400);
  const auto near = open();
  expect_every_size(*near, far, ip(1, 2));
}

TEST_P(PathsTest, BringLongDatagramsAgainOnceTheRouterLetsThemPass) {
  Host router, far;
  plug_in(router, 1, 1500);
  put_behind(router, far, 1500);
  drop_longer_than(1280, router);
  Subscriber subscriber(far.open_transport(Backend::io_uring), {"*"});
  const auto near = open();
  Publisher publisher(*near);
  subscriber.listen_reliably_to(publisher.id());
  publisher.serve({{far.at(ip(2, 2)), "*", true}});
  publisher.publish(make_image(30'000));
  ASSERT_EQ(subscriber.await(1).size(), 1U);
  EXPECT_NE(publisher.port().path_trouble(1), "");
  router.run_here("nft delete table inet silent");
  const auto begin = std::chrono::steady_clock::now();
  std::size_t n = 1;
  EXPECT_TRUE(test::eventually([&] {
    near->poll(begin + n * 11s);
    publisher.publish(make_image(30'000));
    ++n;
    return subscriber.await(n).size() < n || publisher.port().path_trouble(1).empty();
  }));
  EXPECT_EQ(subscriber.await(n).size(), n);
  EXPECT_EQ(far.longest(), payload(1500));
}

}  // namespace
}  // namespace sft::udp
