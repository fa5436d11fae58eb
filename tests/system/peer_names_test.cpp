// A node looks up peers by name, and its name server answers late, never, or with a new address. The node
// never waits for the name server.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <sft/sft.h>
#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/platform/file_descriptor.h"
#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

sockaddr_in at(const std::string& address, std::uint16_t port) {
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(port);
  inet_pton(AF_INET, address.c_str(), &place.sin_addr);
  return place;
}

core::FileDescriptor socket_at(const std::string& address, std::uint16_t port) {
  core::FileDescriptor made(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const sockaddr_in place = at(address, port);
  if (bind(made.get(), reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0) return {};
  return made;
}

/// The name server of this host. It does not answer until the test sets an address.
class NameServer {
 public:
  NameServer() : socket_(socket_at("127.0.0.1", 53)), thread_([this] { serve(); }) {}
  ~NameServer() {
    ends_ = true;
    const sockaddr_in here = at("127.0.0.1", 53);
    sendto(socket_.get(), "", 0, 0, reinterpret_cast<const sockaddr*>(&here), sizeof here);
    thread_.join();
  }
  NameServer(const NameServer&) = delete;
  NameServer& operator=(const NameServer&) = delete;

  /// Sets the address of every name, and answers the questions that have arrived so far.
  void set_address(const std::string& address) {
    const std::scoped_lock lock(mutex_);
    address_ = at(address, 0).sin_addr.s_addr;
    for (const Question& question : std::exchange(unanswered_, {})) answer(question);
  }
  int asked() const { return asked_; }

 private:
  struct Question {
    std::array<char, 512> message{};
    sockaddr_in from{};
  };

  void serve() {
    while (!ends_) {
      Question question;
      socklen_t length = sizeof question.from;
      const ssize_t bytes = recvfrom(socket_.get(), question.message.data(), question.message.size(), 0,
                                     reinterpret_cast<sockaddr*>(&question.from), &length);
      if (bytes < 12) continue;
      ++asked_;
      const std::scoped_lock lock(mutex_);
      address_ ? answer(question) : unanswered_.push_back(question);
    }
  }

  /// Sends the answer: a header of 12 bytes, the question, and one address of 4 bytes (RFC 1035, 4.1).
  void answer(const Question& question) {
    const std::size_t end_of_name = 12 + std::strlen(question.message.data() + 12) + 1;
    std::string answer(question.message.data(), end_of_name + 4);
    answer.replace(2, 10, std::string("\x81\x80\0\1\0\1\0\0\0\0", 10));
    answer += std::string("\xc0\x0c\0\1\0\1\0\0\0\1\0\4", 12);
    answer.append(reinterpret_cast<const char*>(&*address_), sizeof *address_);
    sendto(socket_.get(), answer.data(), answer.size(), 0, reinterpret_cast<const sockaddr*>(&question.from),
           sizeof question.from);
  }

  std::mutex mutex_;
  std::optional<in_addr_t> address_;
  std::vector<Question> unanswered_;
  std::atomic<int> asked_{0};
  std::atomic<bool> ends_{false};
  const core::FileDescriptor socket_;
  std::thread thread_;
};

/// Replaces a file of /etc by a file with the given text, for this isolated host only.
void put(const std::string& file, const std::string& text) {
  const std::string own = "/tmp/" + file;
  std::ofstream(own) << text;
  ASSERT_EQ(mount(own.c_str(), ("/etc/" + file).c_str(), nullptr, MS_BIND, nullptr), 0) << strerror(errno);
}

bool run(const std::string& command) { return std::system(command.c_str()) == 0; }

/// The parameter of the tests is true if the configuration of Cyclone DDS names the peers, and false if the
/// node's settings name them.
class PeerNamesTest : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    const bool has_link =
        run("ip link add near type veth peer name far && ip address add 10.9.0.1/24 dev near && "
            "ip address add 10.9.0.7/24 dev near && ip address add 10.9.0.8/24 dev near && "
            "ip link set near up && ip link set far up");
    if (!has_link) GTEST_SKIP() << "no pair of virtual network devices can be made here";
    put("resolv.conf", "nameserver 127.0.0.1\noptions timeout:30 attempts:5\n");
    put("nsswitch.conf", "hosts: dns\n");
  }

  static NodeOptions options() {
    NodeOptions options;
    options.domain = 0;
    options.transport = TransportChoice::udp;
    options.cyclonedds_config = "";
    if (GetParam()) {
      options.cyclonedds_config = "<Discovery><Peers><Peer Address='robot.example'/></></>";
    } else {
      options.discovery.peers = {"robot.example"};
    }
    return options;
  }
  static std::string warnings_of(const Node& node) {
    std::string text;
    for (const std::string& warning : node.status().discovery_warnings) text += warning + "\n";
    return text;
  }
  static void expect_to_meet(Node& node, Node& newcomer) {
    const auto publisher = node.publisher<PointCloud2>("points").value();
    const auto subscriber = newcomer.subscriber<PointCloud2>("points").value();
    EXPECT_TRUE(eventually([&] { return publisher.status().readers.size() == 1; }));
  }
  /// Opens a socket at the address of a participant, so that the socket gets the datagrams for the
  /// participant. The participants of this test use the first ports.
  static core::FileDescriptor participant_at(const std::string& address) { return socket_at(address, 7440); }
  static bool is_asked(const core::FileDescriptor& participant) {
    pollfd waits{.fd = participant.get(), .events = POLLIN, .revents = 0};
    return poll(&waits, 1, static_cast<int>(std::chrono::milliseconds(hang_timeout).count())) == 1;
  }

  static constexpr const char* unanswered =
      "'robot.example' is not looked for yet: the lookup of its address has not been answered";
};

/// If a node waited for the answer, the lookup would fail first, and the warning would contain this
/// failure.
TEST_P(PeerNamesTest, HoldNeitherANodeNorItsNewcomersUpWhileTheNameServerIsSilent) {
  const NameServer silent;
  Node node = Node::open(options()).value();
  EXPECT_THAT(warnings_of(node), HasSubstr(unanswered));
  Node newcomer = Node::open(options()).value();
  expect_to_meet(node, newcomer);
  ASSERT_TRUE(
      run("ip link set near down && ip link add other type veth peer name behind && "
          "ip link set behind up && ip address add 10.8.0.1/24 dev other && ip link set other up"));
  EXPECT_TRUE(eventually([&] { return node.status().discovery.find("other (10.8.0.1)") != SIZE_MAX; }));
  NodeOptions later = options();
  later.threads.discovery.name_prefix = "later";
  Node another = Node::open(later).value();
  expect_to_meet(node, another);
  EXPECT_THAT(warnings_of(node), HasSubstr(unanswered));
  EXPECT_GT(silent.asked(), 0);
}

TEST_P(PeerNamesTest, AreAskedOnceTheirAddressIsKnownAndAtAnotherOneWhenItChanges) {
  NameServer server;
  Node node = Node::open(options()).value();
  EXPECT_THAT(warnings_of(node), HasSubstr(unanswered));
  const core::FileDescriptor before = participant_at("10.9.0.7"), after = participant_at("10.9.0.8");
  ASSERT_TRUE(before && after);
  server.set_address("10.9.0.7");
  EXPECT_TRUE(is_asked(before));
  EXPECT_TRUE(eventually([&] { return warnings_of(node).empty(); }));
  server.set_address("10.9.0.8");
  ASSERT_TRUE(run("ip address add 10.8.0.1/24 dev near"));
  EXPECT_TRUE(is_asked(after));
  Node newcomer = Node::open(options()).value();
  expect_to_meet(node, newcomer);
}

INSTANTIATE_TEST_SUITE_P(PeersBy, PeerNamesTest, ::testing::Bool(), [](const auto& param) {
  return param.param ? std::string("cyclonedds_config") : std::string("discovery_settings");
});

}  // namespace
}  // namespace sft::test
