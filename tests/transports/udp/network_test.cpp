// Several readers of one publisher on a network of the test. One of the readers cannot be reached or is slow.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/platform/network_monitor.h"
#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/support/test_seed.h"
#include "tests/transports/udp/another_host.h"
#include "tests/transports/udp/backends.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "tests/transports/udp/transfers.h"
#include "udp_transport/io/multicast_links.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::make_image;
using test::on_another_host;
using test::Publisher;
using test::run;
using test::Subscriber;
using Clock = std::chrono::steady_clock;

// 10.9.0.2, an address on the link at which no host answers.
constexpr std::uint32_t dead_address = 0x0A090002;

class NetworkTest : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
    if (const std::string why = test::refusal_of(GetParam()); !why.empty()) GTEST_SKIP() << why;
    run("ip link add near type veth peer name far 2> /dev/null");
    if (!run("ip address replace 10.9.0.1/24 dev near && ip link set near up && ip link set far up"))
      GTEST_SKIP() << "no pair of virtual network devices can be made here";
  }

  std::unique_ptr<core::Network> open(UdpOptions options = {}) {
    options.backend = GetParam();
    return open_udp_transport(options, test::make_pool()).value();
  }
  static core::UdpAddress dead_reader() { return {dead_address, 5000, 32 << 20}; }
};

TEST(NetworkMonitorTest, NoticesAnAddressThatComesAndGoesAndNothingElse) {
  if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
  core::NetworkMonitor monitor;
  EXPECT_FALSE(monitor.changed());
  for (const char* change : {"add", "delete"}) {
    ASSERT_TRUE(run(("ip address " + std::string(change) + " 10.8.0.1/24 dev lo").c_str()));
    EXPECT_TRUE(monitor.changed()) << change;
    EXPECT_FALSE(monitor.changed()) << "it was told";
  }
}

TEST(KnownMulticastLinksTest, AreAskedForOnceUntilTheNetworkChanges) {
  if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
  static int asked;
  asked = 0;
  const auto ask = [](Multicast use) { return ++asked, multicast_links(use); };
  core::NetworkMonitor monitor;
  KnownMulticastLinks links(monitor, ask);
  const auto knows = [&](std::uint32_t own) {
    return std::ranges::count(links.list(Multicast::automatic), own, &MulticastLink::own) > 0;
  };
  EXPECT_FALSE(knows(0x0A080001));
  EXPECT_FALSE(knows(0x0A080001));
  EXPECT_EQ(asked, 1);
  ASSERT_TRUE(run("ip address add 10.8.0.1/24 dev lo"));
  EXPECT_TRUE(knows(0x0A080001));
  EXPECT_TRUE(knows(0x0A080001));
  EXPECT_EQ(asked, 2);
  ASSERT_TRUE(run("ip address delete 10.8.0.1/24 dev lo"));
  EXPECT_FALSE(knows(0x0A080001));
  EXPECT_EQ(asked, 3);
}

/// A writer that gets routes reads the links of this host, and may notice a change of addresses before the
/// node does.
TEST(KnownMulticastLinksTest, OfRoutesDoNotHideAChangeFromTheNode) {
  if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
  const auto transport = open_udp_transport({.backend = Backend::sockets}, test::make_pool()).value();
  Publisher publisher(*transport);
  EXPECT_FALSE(transport->network_changed());
  for (const char* change : {"add", "delete"}) {
    ASSERT_TRUE(run(("ip address " + std::string(change) + " 10.8.0.1/24 dev lo").c_str()));
    publisher.serve({{test::loopback_address(*transport)}});
    EXPECT_TRUE(transport->network_changed()) << change;
    EXPECT_FALSE(transport->network_changed()) << "it was told";
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, NetworkTest, test::both_backends, test::backend_name);

/// Datagrams to the dead host wait for some 3 s until the kernel gives up.
TEST_P(NetworkTest, ServesOthersWhileOneAddressCannotBeReached) {
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"*", "stamp"});
  Publisher to_both(*there, 1), to_other(*there, 2);
  subscriber.listen_to(1);
  subscriber.listen_to(2);
  to_both.serve({{dead_reader()}, {test::loopback_address(*here)}});
  to_other.serve({{test::loopback_address(*here), "stamp"}});
  for (std::size_t n = 0; n < 100; n += 2) {
    to_both.publish(make_image(200'000));
    to_other.publish(make_image(5));
    ASSERT_EQ(subscriber.await(n + 2).size(), n + 2) << "of a publisher with a dead reader, or another";
  }
}

/// A publisher and a fast reader of its samples, each in a process of its own.
class Pair {
 public:
  Pair(std::unique_ptr<core::Network> there, std::unique_ptr<core::Network> here)
      : there_(std::move(there)), here_(std::move(here)) {
    subscriber_.listen_to(publisher_.id());
  }
  /// Serves the fast reader, and a second reader with the same mask if `second` is not null.
  void serve(core::Network* second = nullptr) {
    std::vector<Publisher::Reader> readers{{test::loopback_address(*here_)}};
    if (second != nullptr) readers.insert(readers.begin(), {test::loopback_address(*second)});
    publisher_.serve(readers);
  }
  /// Publishes a sample. Returns the time until the fast reader has it.
  Clock::duration time_of_one() {
    const Clock::time_point begin = Clock::now();
    publisher_.publish(make_image(4'000'000));
    EXPECT_GT(subscriber_.await(came_ + 1).size(), came_);
    ++came_;
    return Clock::now() - begin;
  }
  core::EndpointId publisher() const { return publisher_.id(); }

 private:
  std::unique_ptr<core::Network> there_, here_;
  Subscriber subscriber_{*here_, {"*"}};
  Publisher publisher_{*there_};
  std::size_t came_ = 0;
};

/// A reader that blocks the receiving thread at each sample until the test calls go_on().
class SlowReader final : private core::ArrivalListener {
 public:
  SlowReader(core::Network& transport, core::EndpointId publisher) {
    port_ =
        transport
            .open_reader({.id = 1, .type = &type_support<test::Image>(), .listener = this, .doorbell = {}})
            .value();
    port_->accept({{.wanted = {test::fields<test::Image>("*")}}});
    EXPECT_TRUE(port_->connect({.writer = publisher}));
  }
  ~SlowReader() { let_go_of(std::numeric_limits<std::size_t>::max()); }
  /// Lets the receiving thread run until the next sample.
  void go_on() { let_go_of(came_); }
  std::size_t came() const { return came_; }

 private:
  void let_go_of(std::size_t samples) {
    let_go_ = samples;
    let_go_.notify_all();
  }
  void arrived() noexcept override {
    while (port_->take()) {
      ++came_;
      for (std::size_t samples = let_go_; samples < came_; samples = let_go_) let_go_.wait(samples);
    }
  }
  std::atomic<std::size_t> came_{0}, let_go_{0};
  std::unique_ptr<core::NetworkReader> port_;  // destroyed first; after that no thread calls arrived()
};

/// Samples are published in turn to a pair with the slow reader and to a pair without it, so that both pairs
/// have the same load of the machine. The slow reader continues only after the fast one has got five more
/// samples.
TEST_P(NetworkTest, KeepsThePaceOfAFastReaderBesideASlowOne) {
  Pair alone(open(), open()), beside(open(), open());
  const auto slow = open({.receive_buffer_bytes = 200'000});
  SlowReader slow_reader(*slow, beside.publisher());
  alone.serve();
  beside.serve(slow.get());
  Clock::duration time_alone{}, time_beside{};
  const auto publish = [&] {
    time_alone += alone.time_of_one();
    time_beside += beside.time_of_one();
  };
  for (std::size_t held_up = 1; held_up <= 4; ++held_up) {
    const auto slow_one_has_another = [&] {
      publish();
      return slow_reader.came() == held_up;
    };
    ASSERT_TRUE(test::eventually(slow_one_has_another));
    for (int i = 0; i < 5; ++i) publish();
    slow_reader.go_on();
  }
  EXPECT_LT(time_beside, 3 * time_alone + 400ms) << "the slow one waits for the fast one";
}

/// A link of 1 Mbit/s, with no host behind it.
TEST_P(NetworkTest, ServesOthersWhileOneLinkIsSlow) {
  if (!run("tc qdisc replace dev near root tbf rate 1mbit burst 70kb latency 40s") ||
      !run("ip neighbour replace 10.9.0.3 lladdr 02:00:00:00:00:03 dev near"))
    GTEST_SKIP() << "links of a given rate cannot be made here";
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{{0x0A090003, 5000, 32 << 20}}, {test::loopback_address(*here)}});
  for (std::size_t n = 1; n <= 50; ++n) {
    publisher.publish(make_image(n % 5 == 0 ? 5 : 200'000));
    ASSERT_EQ(subscriber.await(n).size(), n);
  }
}

/// Both hosts lose, repeat and swap received datagrams.
TEST_P(NetworkTest, TransfersAThousandSamplesOfAllSizesReliablyWhereDatagramsGetLost) {
  sft::test::Random random{sft::test::test_seed()};
  SCOPED_TRACE(sft::test::how_to_repeat());
  const auto open_here = [&] {
    const auto seed = static_cast<unsigned>(random());
    return open_udp_transport({.backend = GetParam()}, test::make_pool(),
                              [&](DatagramIo io) {
                                return test::with_faults(
                                    std::move(io), {.loss = 0.05, .repetition = 0.01, .swap = 0.01}, seed);
                              })
        .value();
  };
  std::unique_ptr<core::Network> far;
  core::UdpAddress address;
  address.ip = on_another_host(GetParam() == Backend::io_uring ? 10 : 11, [&] { far = open_here(); });
  if (address.ip == 0) GTEST_SKIP() << "a second host cannot be had here";
  address.port = far->addresses().at(0).port;
  address.receive_buffer_bytes = far->addresses().at(0).receive_buffer_bytes;
  const auto near = open_here();
  Subscriber subscriber(*far, {"*"}, 1000);
  Publisher publisher(*near);
  subscriber.listen_reliably_to(publisher.id());
  publisher.serve({{address, "*", true}});
  test::transfer_all_sizes(publisher, subscriber, random);
}

/// An announcement can name the address of any host, even of one that has requested nothing.
TEST_P(NetworkTest, SendsNextToNothingToAHostThatDidNotAskForIt) {
  int socket = -1;
  sockaddr_in at{.sin_family = AF_INET, .sin_port = 0, .sin_addr = {}, .sin_zero = {}};
  const std::uint32_t ip = on_another_host(GetParam() == Backend::io_uring ? 20 : 21, [&] {
    socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    socklen_t length = sizeof at;
    ::bind(socket, reinterpret_cast<sockaddr*>(&at), length);
    ::getsockname(socket, reinterpret_cast<sockaddr*>(&at), &length);
  });
  if (ip == 0) GTEST_SKIP() << "a second host cannot be had here";
  const auto there = open();
  Publisher large(*there, 1), small(*there, 2);
  const core::UdpAddress victim{ip, ntohs(at.sin_port), 32 << 20};
  large.serve({{victim, "*", true}, {victim, "stamp"}});
  small.serve({{victim, "*", true}, {victim, "*"}});
  constexpr std::size_t ethernet_and_ip = 42;
  std::size_t came = 0;
  std::vector<std::byte> datagram(65'536);
  sft::test::Pace pace(10ms, sft::test::Keeps::rate);
  for (const auto end = Clock::now() + 2s; Clock::now() < end; pace.await_turn()) {
    large.publish(make_image(1'000'000));
    small.publish(make_image(100));
    for (ssize_t n; (n = ::recv(socket, datagram.data(), datagram.size(), 0)) >= 0;)
      came += static_cast<std::size_t>(n) + ethernet_and_ip;
  }
  ::close(socket);
  EXPECT_GT(came, 0U) << "it is asked";
  EXPECT_LT(came, 40'000U);
  EXPECT_NE(small.port().path_trouble(1), "");
}

TEST_P(NetworkTest, SendsNextToNothingToAPortOfThisHostThatNobodyAskedFor) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  sockaddr_in at{.sin_family = AF_INET, .sin_port = 0, .sin_addr = {htonl(INADDR_LOOPBACK)}, .sin_zero = {}};
  socklen_t length = sizeof at;
  ASSERT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&at), length), 0);
  ASSERT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&at), &length), 0);
  const auto there = open();
  Publisher publisher(*there);
  publisher.serve({{{INADDR_LOOPBACK, ntohs(at.sin_port), 32 << 20}, "*", true}});
  std::vector<std::byte> datagram(65'536);
  std::size_t came = 0;
  for (std::size_t n = 0; n < 200; ++n) publisher.publish(make_image(n % 2 == 0 ? 1'000'000 : 10'000));
  for (ssize_t n; (n = ::recv(socket, datagram.data(), datagram.size(), 0)) >= 0;)
    came += static_cast<std::size_t>(n);
  EXPECT_LE(came, 26'000U);
  ::close(socket);
  for (int n = 0; n < 10; ++n) publisher.publish(make_image(10'000));
  EXPECT_TRUE(test::eventually([&] { return !publisher.port().path_trouble(1).empty(); }))
      << "the host says so";
}

TEST_P(NetworkTest, GoesOnWithinASecondAfterAHostThatCouldNotBeReachedIsBack) {
  const unsigned net = GetParam() == Backend::io_uring ? 22 : 23;
  std::unique_ptr<core::Network> far;
  core::UdpAddress address;
  address.ip = on_another_host(net, [&] { far = open(); });
  if (address.ip == 0) GTEST_SKIP() << "a second host cannot be had here";
  address.port = far->addresses().at(0).port;
  const auto near = open();
  Subscriber reliable(*far, {"*"}), best_effort(*far, {"*"});
  Publisher one(*near, 1), other(*near, 2);
  reliable.listen_reliably_to(1);
  best_effort.listen_to(2);
  one.serve({{address, "*", true}});
  other.serve({{address}});
  sft::test::Pace pace(5ms);
  const auto publish_until = [&](const auto& enough, std::chrono::milliseconds at_most) {
    for (const auto end = Clock::now() + at_most; Clock::now() < end && !enough(); pace.await_turn()) {
      one.publish(make_image(20'000));
      other.publish(make_image(20'000));
    }
    return enough();
  };
  const auto both_get_more = [&] {
    return [&, before = reliable.await(0).size(), before_other = best_effort.await(0).size()] {
      return reliable.await(0).size() > before && best_effort.await(0).size() > before_other;
    };
  };
  ASSERT_TRUE(publish_until(both_get_more(), 20s));
  const std::string neighbour = "10.9." + std::to_string(net) + ".2", link = "to" + std::to_string(net);
  ASSERT_TRUE(run("ip neighbour replace " + neighbour + " lladdr 02:00:00:00:00:03 dev " + link));
  publish_until([] { return false; }, 3s);
  EXPECT_NE(one.port().path_trouble(1), "");
  ASSERT_TRUE(run("ip neighbour delete " + neighbour + " dev " + link));
  EXPECT_TRUE(publish_until(both_get_more(), 1s));
  EXPECT_EQ(one.port().path_trouble(1), "");
}

TEST_P(NetworkTest, GoesOnWhenThePathTakesShorterDatagrams) {
  ASSERT_TRUE(
      run("ip address replace 10.9.8.1/32 dev lo && ip route replace 10.9.8.1 dev lo table local mtu 60000"));
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{{0x0A090801, test::loopback_address(*here).port, 32 << 20}}});
  std::size_t published = 0;
  const auto arrives = [&] {
    const std::size_t before = subscriber.await(0).size();
    return test::eventually([&] {
      publisher.publish(make_image(300'000 + ++published));
      return subscriber.await(before + 1, 1s).size() > before;
    });
  };
  EXPECT_TRUE(arrives());
  ASSERT_TRUE(run("ip route replace 10.9.8.1 dev lo table local mtu 1500"));
  EXPECT_TRUE(arrives());
  EXPECT_EQ(published, 2U) << "what was refused is cut again";
}

TEST_P(NetworkTest, GoesOnWhenTheHostGetsAnotherAddress) {
  const auto with_address = [](const std::string& address) {
    return run(("ip address flush dev near && ip address add " + address + "/24 dev near").c_str()) &&
           run("ip neighbour replace 10.9.0.3 lladdr 02:00:00:00:00:03 dev near");
  };
  ASSERT_TRUE(with_address("10.9.0.5"));
  const auto there = open();
  Publisher publisher(*there);
  publisher.serve({{{0x0A090003, 5000, 32 << 20}}});
  EXPECT_EQ(publisher.publish(make_image(5)), core::SendStatus::sent);
  ASSERT_TRUE(with_address("10.9.0.6"));
  publisher.publish(make_image(5));  // the first sample whose sending may fail
  EXPECT_EQ(publisher.publish(make_image(5)), core::SendStatus::sent);
}

}  // namespace
}  // namespace sft::udp
