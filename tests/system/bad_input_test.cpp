// Bad input is refused, and the error says what is wrong and what to do.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>

#include <algorithm>
#include <functional>
#include <mutex>
#include <string>
#include <utility>

#include <nav_msgs/msg/Odometry.hpp>

#include "tests/system/fixture.h"
#include "tests/system/opened_by_child.h"
#include "udp_transport/wire/datagram.h"

namespace sft::test {
namespace {

using ::testing::AnyOf;

class BadInputTest : public ::testing::Test {
 protected:
  static Node udp_node(const std::string& name) { return Node::open(node_options(Way::udp, name)).value(); }
};

TEST_F(BadInputTest, ABusyPortIsAnErrorThatNamesIt) {
  const int taken = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  ASSERT_EQ(bind(taken, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  socklen_t length = sizeof address;
  getsockname(taken, reinterpret_cast<sockaddr*>(&address), &length);
  NodeOptions options = node_options(Way::udp, "a");
  options.udp.port = ntohs(address.sin_port);
  const auto node = Node::open(options);
  close(taken);
  ASSERT_FALSE(node);
  EXPECT_EQ(node.error().code, Errc::address_in_use);
  EXPECT_NE(node.error().message.find(std::to_string(options.udp.port)), std::string::npos)
      << node.error().message;
}

TEST_F(BadInputTest, AMessageThatIsNotSentIsNamedInTheLogThoughTheProgramDoesNotLook) {
  std::mutex mutex;
  std::string log;
  NodeOptions options = node_options(Way::udp, "a");
  options.log = [&](LogLevel level, std::string_view line) {
    const std::scoped_lock lock(mutex);
    if (level == LogLevel::warning) log.append(line) += '\n';
  };
  Node node = Node::open(options).value();
  auto camera = node.publisher<PointCloud2>("camera", {.max_sample_bytes = 1000}).value();
  PointCloud2 large;
  large.data.resize(1000);
  for (int i = 0; i < 100; ++i) camera.publish(large);
  EXPECT_TRUE(eventually([&] {
    const std::scoped_lock lock(mutex);
    return log.find("a: a message is not sent: topic 'camera': ") == 0 &&
           log.find("raise PublisherOptions::max_sample_bytes") != std::string::npos;
  })) << log;
}

TEST_F(BadInputTest, AProgramWithTooFewThreadsGetsAnErrorThatSaysSo) {
  constexpr uid_t nobody_else = 61'234;
  const auto opened_with = [](rlim_t threads) {
    return opened_by_child(
        [&] {
          const rlimit limit{threads, threads};
          setrlimit(RLIMIT_NPROC, &limit);
          if (getuid() == 0 && setresuid(nobody_else, nobody_else, nobody_else) != 0) _exit(99);
        },
        "RLIMIT_NPROC");
  };
  if (getuid() != 0) GTEST_SKIP() << "the other processes of this user count, too";
  for (rlim_t threads = 1; threads <= 16; ++threads)
    EXPECT_EQ(opened_with(threads), Opened::limit_exceeded) << threads;
  for (rlim_t threads = 17; threads <= 32; ++threads)
    EXPECT_THAT(opened_with(threads), AnyOf(Opened::limit_exceeded, Opened::node)) << threads;
  EXPECT_EQ(opened_with(100), Opened::node);
}

TEST_F(BadInputTest, AProgramWithTooFewDescriptorsGetsAnErrorThatSaysSo) {
  const auto opened_with = [](rlim_t descriptors) {
    return opened_by_child(
        [&] {
          const rlimit limit{descriptors, descriptors};
          setrlimit(RLIMIT_NOFILE, &limit);
        },
        "RLIMIT_NOFILE");
  };
  for (rlim_t descriptors = 0; descriptors <= 48; descriptors += 6)
    EXPECT_EQ(opened_with(descriptors), Opened::limit_exceeded) << descriptors;
  for (rlim_t descriptors = 49; descriptors <= 80; ++descriptors)
    EXPECT_THAT(opened_with(descriptors), AnyOf(Opened::limit_exceeded, Opened::node)) << descriptors;
  EXPECT_EQ(opened_with(200), Opened::node);
}

/// Cyclone DDS waits with select(2). Services often have a limit on descriptors that is greater than the
/// maximum number that select(2) can handle.
TEST_F(BadInputTest, AProgramWithMoreOpenFilesThanSelectCanTakeGetsAnErrorThatSaysSo) {
  rlimit usual{};
  getrlimit(RLIMIT_NOFILE, &usual);
  if (usual.rlim_max < 4096 && getuid() != 0) GTEST_SKIP() << "the limit on open files cannot be raised";
  const auto opened_beside = [&](int files) {
    return opened_by_child(
        [&] {
          const rlimit limit{4096, std::max<rlim_t>(usual.rlim_max, 4096)};
          setrlimit(RLIMIT_NOFILE, &limit);
          for (int i = 0; i < files; ++i) static_cast<void>(::open("/dev/null", O_RDONLY));
        },
        "with numbers below 1024");
  };
  for (const int files : {1000, 1006, 1015, 1021, 2000, 3000})
    EXPECT_EQ(opened_beside(files), Opened::limit_exceeded) << files;
  EXPECT_EQ(opened_beside(800), Opened::node);
}

TEST_F(BadInputTest, WhoMayNotWriteFilesHasANodeForUdp) {
  for (const rlim_t bytes : {0, 1000, 65'535, 65'536, 10'000'000}) {
    EXPECT_EQ(opened_by_child(
                  [&] {
                    const rlimit limit{bytes, bytes};
                    setrlimit(RLIMIT_FSIZE, &limit);
                  },
                  "RLIMIT_FSIZE"),
              Opened::node)
        << bytes;
  }
}

TEST_F(BadInputTest, TopicsHaveNamesAndDomainsAreSmallNumbers) {
  Node node = udp_node("a");
  EXPECT_FALSE(node.publisher<PointCloud2>(""));
  EXPECT_FALSE(node.publisher<PointCloud2>(std::string(300, 'x')));
  EXPECT_FALSE(Node::open({.domain = 233}));
}

TEST_F(BadInputTest, NamesAreTextAndRefusalsOfThemAreShort) {
  Node node = udp_node("a");
  for (const std::string& topic :
       {std::string("a\0b", 3), std::string("a\nb"), std::string("\xff"), std::string("//a"),
        std::string("~x"), std::string("~//x"), std::string("a "), std::string(10'000, 'x')}) {
    const auto refused = node.subscriber<PointCloud2>(topic);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::invalid_argument);
    EXPECT_LT(refused.error().message.size(), 200U);
    EXPECT_EQ(refused.error().message.find_first_of(std::string("\0\n\xff", 3)), std::string::npos);
  }
  EXPECT_FALSE(Node::open({.name = "a\x1b[2J"}));
  EXPECT_FALSE(Node::open({.name = std::string(10'000, 'n')}));
}

TEST_F(BadInputTest, AnEndpointCannotChooseWhatItsNodeRulesOut) {
  Node node = udp_node("a");
  EXPECT_FALSE(node.publisher<PointCloud2>("points", {.transport = TransportChoice::shm}));
}

TEST_F(BadInputTest, TwoTypesOnOneTopicNeverMatchAndBothSidesSayWhy) {
  warnings_expected = true;
  Node a = udp_node("a");
  Node b = udp_node("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<nav_msgs::msg::Odometry>("points").value();
  ASSERT_TRUE(
      eventually([&] { return pub.status().readers.size() == 1 && sub.status().writers.size() == 1; }));
  EXPECT_FALSE(pub.status().readers[0].served);
  EXPECT_NE(pub.status().readers[0].reason.find("Odometry"), std::string::npos);
  EXPECT_FALSE(sub.status().writers[0].matched);
  pub.publish({});
  EXPECT_FALSE(sub.wait(20ms));
}

TEST_F(BadInputTest, AMessageThatCdrCannotCarryIsInvalid) {
  expected_warning = "a message is not sent: topic 'points': ";
  Node a = udp_node("a");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = a.subscriber<PointCloud2>("points").value();
  ASSERT_TRUE(eventually([&] { return !pub.status().readers.empty() && pub.status().readers[0].served; }));
  PointCloud2 message;
  message.header.frame_id = std::string("a\0b", 3);
  EXPECT_EQ(pub.why_invalid(), "");
  EXPECT_EQ(pub.publish(message), PublishStatus::invalid);
  const std::string why =
      "topic 'points': 'header.frame_id' has a NUL behind 1 characters; a string ends at its first one";
  EXPECT_EQ(pub.why_invalid(), why);
  EXPECT_EQ(pub.loan(message).error().message, why);
}

TEST_F(BadInputTest, TheErrorOfATooLargeMessageNamesItsLargestFieldAndTheLimit) {
  expected_warning = "a message is not sent: topic 'points': ";
  Node a = udp_node("a");
  auto pub = a.publisher<PointCloud2>("points", {.max_sample_bytes = 1000}).value();
  auto sub = a.subscriber<PointCloud2>("points").value();
  ASSERT_TRUE(eventually([&] { return !pub.status().readers.empty() && pub.status().readers[0].served; }));
  PointCloud2 message;
  message.data.resize(2000);
  EXPECT_EQ(pub.publish(message), PublishStatus::invalid);
  EXPECT_EQ(pub.why_invalid(),
            "topic 'points': the message has 2045 bytes, 2004 of them in 'data'; at most 1000 bytes may be "
            "sent: raise PublisherOptions::max_sample_bytes");
  const auto loan = pub.loan({}, {.data = 3000});
  ASSERT_FALSE(loan);
  EXPECT_EQ(loan.error().code, Errc::limit_exceeded);
  EXPECT_NE(loan.error().message.find("3004 of them in 'data'"), std::string::npos) << loan.error().message;
}

TEST_F(BadInputTest, APayloadThatIsNotTheTypeIsAnError) {
  Node a = udp_node("a");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = a.subscriber<PointCloud2>("points").value();  // without a reader the payload is not checked
  ASSERT_TRUE(eventually([&] { return !pub.status().readers.empty() && pub.status().readers[0].served; }));
  const std::vector<std::byte> payload(100, std::byte{0xff});
  EXPECT_FALSE(pub.publish_cdr(payload));
  std::vector<std::byte> little = payload;
  little[0] = little[2] = little[3] = std::byte{0};
  little[1] = std::byte{1};
  const auto result = pub.publish_cdr(little);
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message.find("PointCloud2"), std::string::npos);
}

TEST_F(BadInputTest, DatagramsOfNoOneAreCountedAndHurtNobody) {
  Node a = udp_node("a");
  NodeOptions options = node_options(Way::udp, "b");
  options.udp.port = 17'000;  // less than 32'768, the first port that the system assigns by itself
  Node b = Node::open(options).value();
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::height>("points").value();
  ASSERT_TRUE(eventually([&] { return !pub.status().readers.empty() && pub.status().readers[0].served; }));
  const int hostile = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(options.udp.port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::array<std::uint8_t, 64> bytes{};
  for (int i = 0; i < 200; ++i) {
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rand());
    if (i % 2 == 0) bytes[0] = static_cast<std::uint8_t>(udp::wire_version << 4 | i / 2 % 16);
    ASSERT_GT(sendto(hostile, bytes.data(), static_cast<std::size_t>(1 + i % 64), 0,
                     reinterpret_cast<sockaddr*>(&to), sizeof to),
              0);
  }
  close(hostile);
  EXPECT_TRUE(eventually([&] {
    const NodeStatus status = b.status();
    return status.datagrams_malformed + status.datagrams_unknown + status.over_limit == 200;
  })) << b.status().datagrams_malformed
      << " + " << b.status().datagrams_unknown;
  PointCloud2 message;
  message.height = 4;
  pub.publish(message);
  ASSERT_TRUE(sub.wait(hang_timeout));
}

}  // namespace
}  // namespace sft::test
