// One publisher and eight readers with two masks, each on a host of its own, on one bridge: what is on the
// wire.
#include <gtest/gtest.h>
#include <ifaddrs.h>
#include <linux/if_link.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "endpoints.h"
#include "tests/support/isolated_host.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {
namespace {

using test::eventually;
using test::Publisher;
using test::Subscriber;

constexpr std::size_t hosts = 8;
constexpr std::size_t samples = 100;

bool run(const std::string& command) { return std::system(command.c_str()) == 0; }

class FanOutTest : public testing::TestWithParam<bool> {
 protected:
  struct Host {
    std::unique_ptr<core::Transport> transport;
    std::unique_ptr<Subscriber> subscriber;
    core::UdpAddress address;
    std::string mask;
    std::uint32_t since = 0;  ///< so many were published before it was served
  };

  void SetUp() override {
    if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
    if (!run("ip link add bridge type bridge && ip address add 10.20.0.1/24 dev bridge && "
             "ip link set bridge up && ip link set lo up"))
      GTEST_SKIP() << "no bridge can be made here";
    writer_ = open_udp_transport({}, test::make_pool()).value();
    publisher_ = std::make_unique<Publisher>(*writer_);
    for (std::size_t i = 0; i < hosts; ++i) ASSERT_TRUE(add_host(i));
  }
  void TearDown() override {
    hosts_.clear();
    std::system("ip link delete bridge 2> /dev/null");
  }

  bool add_host(std::size_t number) {
    Host host;
    host.mask = number % 2 == 0 ? "data" : "name";
    const std::string port = "port" + std::to_string(number), end = "end" + std::to_string(number);
    const std::string address = "10.20.0." + std::to_string(number + 2);
    bool made = run("ip link add " + port + " type veth peer name " + end + " && ip link set " + port +
                    " master bridge up");
    std::thread([&] {
      made = made && ::unshare(CLONE_NEWNET) == 0 &&
             run("nsenter -t " + std::to_string(::getpid()) + " -n ip link set " + end + " netns " +
                 std::to_string(::gettid())) &&
             run("ip address add " + address + "/24 dev " + end + " && ip link set " + end + " up");
      if (!made) return;
      host.transport = open_udp_transport({}, test::make_pool()).value();
      host.address = host.transport->addresses().at(0);
      host.subscriber =
          std::make_unique<Subscriber>(*host.transport, std::vector{host.mask}, 10'000, number + 1);
      if (GetParam()) host.subscriber->listen_reliably_to(publisher_->id());
      if (!GetParam()) host.subscriber->listen_to(publisher_->id());
    }).join();
    hosts_.push_back(std::move(host));
    return made;
  }

  void serve(std::size_t first) {
    for (std::size_t i = served_; i < first; ++i) hosts_[i].since = published_;
    served_ = first;
    std::vector<Publisher::Reader> readers;
    for (std::size_t i = 0; i < first; ++i)
      readers.push_back({hosts_[i].address, hosts_[i].mask, GetParam()});
    publisher_->serve(readers);
  }
  /// Whether everybody has all.
  bool all_came() {
    for (std::size_t i = 0; i < served_; ++i) {
      const std::size_t count = published_ - hosts_[i].since;
      if (hosts_[i].subscriber->await(count).size() != count) return false;
    }
    return true;
  }
  void publish() {
    ASSERT_TRUE(all_came());
    test::Image image = test::make_image(5000, ++published_);
    image.name.assign(3000, 'n');
    publisher_->publish(image);
    writer_->poll(std::chrono::steady_clock::now());
  }
  static std::uint32_t bytes_on_the_wire() {
    std::uint32_t bytes = 0;
    ifaddrs* list = nullptr;
    if (::getifaddrs(&list) != 0) return 0;
    for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
      const bool is_bridge = i->ifa_addr != nullptr && i->ifa_addr->sa_family == AF_PACKET &&
                             i->ifa_name == std::string("bridge");
      if (is_bridge) bytes = static_cast<const rtnl_link_stats*>(i->ifa_data)->tx_bytes;
    }
    ::freeifaddrs(list);
    return bytes;
  }
  double bytes_of_a_sample() {
    publish();
    const std::uint32_t before = bytes_on_the_wire();
    for (std::size_t i = 0; i < samples; ++i) publish();
    return static_cast<double>(bytes_on_the_wire() - before) / samples;
  }
  bool all_are_in_groups() {
    for (core::EndpointId reader = 1; reader <= served_; ++reader) {
      const std::string state = publisher_->port().multicast(reader);
      if (!state.starts_with("group ") || state.ends_with("more")) return false;
    }
    return true;
  }

  std::unique_ptr<core::Transport> writer_;
  std::unique_ptr<Publisher> publisher_;
  std::vector<Host> hosts_;
  std::size_t served_ = 0;
  std::uint32_t published_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Each, FanOutTest, testing::Bool(),
                         [](const auto& param) { return param.param ? "Reliable" : "BestEffort"; });

TEST_P(FanOutTest, PutsBytesOnTheWireByMasksAndNotByReceivers) {
  serve(2);
  const double two_readers = bytes_of_a_sample();
  serve(hosts);
  const double alone = bytes_of_a_sample();
  ASSERT_TRUE(eventually([this] {
    publish();
    return HasFatalFailure() || all_are_in_groups();
  })) << publisher_->port().multicast(1);
  const double together = bytes_of_a_sample();
  std::printf("bytes for each sample: two readers %.0f; eight alone %.0f, by groups %.0f\n", two_readers,
              alone, together);
  RecordProperty("bytes_together", static_cast<int>(together));
  EXPECT_GT(alone, 3.5 * two_readers);
  EXPECT_LT(together, 1.05 * two_readers);
  EXPECT_TRUE(all_came());
}

}  // namespace
}  // namespace sft::udp
