// Publishers serve readers of plain DDS, which do not use SFT, on this host and on another one.
#include <dds/dds.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <builtin_interfaces/msg/Time.hpp>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>

#include "core/platform/domain_id.h"
#include "core/platform/file_descriptor.h"
#include "tests/support/encoded.h"
#include "tests/support/isolated_host.h"
#include "tests/system/fixture.h"
#include "tools/hosts/network.h"

namespace sft::test {
namespace {

using builtin_interfaces::msg::Time;
using testing::HasSubstr;
using VanillaDds = NodeOptions::VanillaDds;

/// A process of the program vanilla_reader on a host.
class VanillaReader {
 public:
  struct How {
    std::string topic = "rt/points";
    std::string reliability = "reliable", durability = "volatile";
    int depth = 10;
  };
  VanillaReader(const hosts::NetworkNamespace& host, const How& how) {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    const std::string program = program_directory() + "/vanilla_reader";
    const std::string domain = std::to_string(core::domain_id({}, std::getenv("ROS_DOMAIN_ID")).value());
    const std::string depth = std::to_string(how.depth);
    process_ = fork();
    if (process_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      if (host.enter())
        execl(program.c_str(), program.c_str(), domain.c_str(), how.topic.c_str(), how.reliability.c_str(),
              how.durability.c_str(), depth.c_str(), nullptr);
      _exit(1);
    }
    close(ends[1]);
    output_ = core::FileDescriptor(ends[0]);
  }
  ~VanillaReader() { kill_now(); }
  VanillaReader(const VanillaReader&) = delete;
  VanillaReader& operator=(const VanillaReader&) = delete;

  void kill_now() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  void hold_up() const { kill(process_, SIGSTOP); }
  void let_go() const { kill(process_, SIGCONT); }

  struct Sample {
    std::vector<std::byte> body;  ///< the body without padding
    std::chrono::nanoseconds stamp{0};
  };
  /// Returns the next sample, or an empty one if no sample arrives.
  Sample take() {
    while (samples_.empty() && read_record(hang_timeout)) continue;
    if (samples_.empty()) return {};
    Sample sample = std::move(samples_.front());
    samples_.erase(samples_.begin());
    return sample;
  }
  /// Waits until that number of writers matches.
  bool matches(std::uint32_t writers) {
    while (matched_ != writers && read_record(hang_timeout)) continue;
    return matched_ == writers;
  }
  /// Returns the number of matching writers that the process has reported last.
  std::uint32_t matched() {
    while (read_record(std::chrono::milliseconds(0))) continue;
    return matched_;
  }

 private:
  struct Head {
    std::int64_t stamp = 0;
    std::uint32_t kind = 0, bytes = 0;
  };
  bool read_all(void* to, std::size_t bytes) {
    for (std::size_t done = 0; done < bytes;) {
      const ssize_t n = read(output_.get(), static_cast<std::byte*>(to) + done, bytes - done);
      if (n <= 0) return false;
      done += static_cast<std::size_t>(n);
    }
    return true;
  }
  bool read_record(std::chrono::milliseconds within) {
    pollfd ready{output_.get(), POLLIN, 0};
    Head head;
    if (poll(&ready, 1, static_cast<int>(within.count())) <= 0 || !read_all(&head, sizeof head)) return false;
    std::vector<std::byte> bytes(head.bytes);
    if (!read_all(bytes.data(), bytes.size())) return false;
    if (head.kind == 1) {
      std::memcpy(&matched_, bytes.data(), sizeof matched_);
    } else {
      const std::size_t padding = std::to_integer<std::size_t>(bytes.at(3)) & 3;
      samples_.push_back({{bytes.begin() + 4, bytes.end() - static_cast<long>(padding)},
                          std::chrono::nanoseconds(head.stamp)});
    }
    return true;
  }

  pid_t process_ = -1;
  core::FileDescriptor output_;
  std::uint32_t matched_ = 0;
  std::vector<Sample> samples_;
};

/// Tests in which the publisher's node is on the first of two hosts.
class VanillaTest : public ::testing::Test {
 protected:
  VanillaTest() {
    warnings_expected = false;
    expected_warning = nullptr;
    EXPECT_TRUE(network_.host(0).enter());
    use_lease("2 s");
  }
  /// Sets the lease of the node and of the readers. A reader that was killed is lost after this time.
  static void use_lease(const std::string& lease) {
    const std::string config = "<Discovery><LeaseDuration>" + lease +
                               "</></>,<Internal><SocketReceiveBufferSize min=\"default\" max=\"4MB\"/></>";
    setenv("CYCLONEDDS_URI", config.c_str(), 1);
  }
  Node open(Way way, VanillaDds choice = VanillaDds::automatic) {
    NodeOptions options = node_options(way, "camera");
    options.vanilla_dds = choice;
    return Node::open(options).value();
  }
  static PointCloud2 cloud(std::uint32_t number, std::size_t bytes = 1000) {
    PointCloud2 c;
    c.header.stamp.sec = static_cast<std::int32_t>(number);
    c.header.frame_id = "lidar";
    c.height = number;
    c.width = number + 1;
    c.fields.resize(2);
    c.fields[1].name = "y";
    c.data.resize(bytes);
    for (std::size_t i = 0; i < bytes; i += 97) c.data[i] = static_cast<std::uint8_t>(i + number);
    return c;
  }
  static std::vector<std::byte> body_of(const PointCloud2& message) { return Encoded(message).bytes(); }
  template <class P>
  static bool serves(const P& publisher, std::size_t readers) {
    return eventually([&] { return publisher.status().vanilla_readers == readers; });
  }
  template <class P>
  static void expect_served(const P& publisher, std::size_t readers) {
    EXPECT_TRUE(eventually([&] {
      const PublisherStatus status = publisher.status();
      return std::ranges::count_if(status.readers, &PublisherStatus::Reader::served) ==
             static_cast<std::ptrdiff_t>(readers);
    }));
  }
  /// Returns true if the reader finally gets a sample with this body.
  static bool comes_to(VanillaReader& reader, const std::vector<std::byte>& body) {
    for (;;) {
      const VanillaReader::Sample sample = reader.take();
      if (sample.body == body) return true;
      if (sample.body.empty()) return false;
    }
  }
  static std::multiset<std::string> names_of_threads() {
    std::multiset<std::string> names;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
      std::string name;
      std::getline(std::ifstream(task.path() / "comm"), name);
      names.insert(name);
    }
    return names;
  }
  static std::uint32_t control_domain() { return core::domain_id({}, std::getenv("ROS_DOMAIN_ID")).value(); }

  const hosts::EmulatedNetwork network_ = hosts::EmulatedNetwork::create(2).value();
};

struct Case {
  Way way = Way::udp;
  std::size_t host = 0;  ///< the number of the reader's host
  const char* reliability = "reliable";
};
std::string name_of_case(const testing::TestParamInfo<Case>& one) {
  return std::string(one.param.way == Way::shm ? "shm_" : "udp_") +
         (one.param.host == 0 ? "same_host_" : "other_host_") + one.param.reliability;
}
class VanillaReadersTest : public VanillaTest, public testing::WithParamInterface<Case> {};

TEST_P(VanillaReadersTest, GetTheBytesAndTheStampOfEachMessage) {
  Node node = open(GetParam().way);
  auto pub = node.publisher<PointCloud2>("points").value();
  auto sub = node.subscriber<PointCloud2>("points").value();
  VanillaReader reader(network_.host(GetParam().host), {.reliability = GetParam().reliability});
  ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
  expect_served(pub, 1);
  for (std::uint32_t i = 0; i < 5; ++i) {
    const std::size_t bytes = i < 4 ? 1000 + i : 300'000;  // the sizes need all possible amounts of padding
    ASSERT_EQ(pub.publish(cloud(i, bytes)), PublishStatus::ok);
    const VanillaReader::Sample sample = reader.take();
    EXPECT_EQ(sample.body, body_of(cloud(i, bytes)));
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto ours = sub.take();
    EXPECT_EQ(sample.stamp, ours.info().source_stamp.time_since_epoch());
    EXPECT_FALSE(sub.take()) << "once each";
  }
}

INSTANTIATE_TEST_SUITE_P(Of, VanillaReadersTest,
                         testing::Values(Case{Way::udp, 0, "reliable"}, Case{Way::udp, 1, "reliable"},
                                         Case{Way::udp, 1, "best_effort"}, Case{Way::shm, 0, "reliable"},
                                         Case{Way::shm, 1, "best_effort"}),
                         name_of_case);

TEST_F(VanillaTest, AReaderThatWasThereBeforeThePublisherIsServed) {
  for (const std::size_t host : {0, 1}) {
    VanillaReader reader(network_.host(host), {});
    Node node = open(Way::udp);
    auto pub = node.publisher<PointCloud2>("points").value();
    ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
    pub.publish(cloud(7));
    EXPECT_EQ(reader.take().body, body_of(cloud(7)));
  }
}

TEST_F(VanillaTest, LatchedReadersGetWhatThePublisherRetainsInOrderAndThenWhatFollows) {
  Node node = open(Way::shm);
  auto pub =
      node.publisher<PointCloud2>("points", {.durability = transient_local, .history_depth = 3}).value();
  for (std::uint32_t i = 0; i < 5; ++i) pub.publish(cloud(i));
  VanillaReader late(network_.host(1), {.durability = "latched"});
  for (std::uint32_t i = 2; i < 5; ++i) EXPECT_EQ(late.take().body, body_of(cloud(i)));
  VanillaReader later(network_.host(0), {.durability = "latched"});
  for (std::uint32_t i = 2; i < 5; ++i) EXPECT_EQ(later.take().body, body_of(cloud(i)));
  pub.publish(cloud(5));
  EXPECT_EQ(late.take().body, body_of(cloud(5)));
  EXPECT_EQ(later.take().body, body_of(cloud(5)));
}

TEST_F(VanillaTest, AfterAReaderWasKilledTheNextOneIsServed) {
  Node node = open(Way::udp);
  auto pub = node.publisher<PointCloud2>("points").value();
  VanillaReader first(network_.host(1), {});
  ASSERT_TRUE(serves(pub, 1));
  first.kill_now();
  ASSERT_TRUE(serves(pub, 0));
  EXPECT_EQ(pub.publish(cloud(1)), PublishStatus::ok);
  VanillaReader second(network_.host(1), {});
  ASSERT_TRUE(serves(pub, 1) && second.matches(1));
  pub.publish(cloud(2));
  EXPECT_EQ(second.take().body, body_of(cloud(2)));
}

TEST_F(VanillaTest, AReaderThatWasStoppedHoldsFewSamplesAndNobodyElseMissesOne) {
  use_lease("100 s");
  NodeOptions options = node_options(Way::udp, "camera");
  options.udp.memory_limit_bytes = 32 << 20;
  Node node = Node::open(options).value();
  auto pub = node.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto sub = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  VanillaReader stopped(network_.host(1), {});
  VanillaReader other(network_.host(1), {});
  ASSERT_TRUE(serves(pub, 2) && stopped.matches(1) && other.matches(1));
  expect_served(pub, 1);
  stopped.hold_up();
  for (std::uint32_t i = 0; i < 60; ++i) {
    ASSERT_EQ(pub.publish(cloud(i, 1'000'000)), PublishStatus::ok);
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto ours = sub.take();
    EXPECT_EQ(ours->height(), i);
    EXPECT_EQ(other.take().body, body_of(cloud(i, 1'000'000)));
  }
  stopped.let_go();
  EXPECT_TRUE(comes_to(stopped, body_of(cloud(59, 1'000'000))));
}

TEST_F(VanillaTest, TheLogSaysWhyAReaderIsNotServed) {
  std::mutex mutex;
  std::vector<std::string> lines;
  NodeOptions options = node_options(Way::udp, "camera");
  options.log = [&](LogLevel level, std::string_view line) {
    const std::lock_guard lock(mutex);
    if (level == LogLevel::warning) lines.emplace_back(line);
  };
  Node node = Node::open(options).value();
  auto pub = node.publisher<PointCloud2>("points").value();
  auto other = node.publisher<Time>("time").value();
  VanillaReader latched(network_.host(1), {.durability = "latched"});
  VanillaReader of_other(network_.host(1), {.topic = "rt/time"});
  const auto logged = [&](const std::string& part) {
    return eventually([&] {
      const std::lock_guard lock(mutex);
      return std::ranges::any_of(lines,
                                 [&](const std::string& line) { return line.find(part) != line.npos; });
    });
  };
  EXPECT_TRUE(
      logged("points: a reader of DDS is not served: incompatible QoS: durability volatile is offered"));
  EXPECT_TRUE(
      logged("time: a reader of DDS is not served: its type is 'sensor_msgs::msg::dds_::PointCloud2_'"));
}

TEST_F(VanillaTest, WithoutSuchNodesThereIsNothingMoreThanIfTheyWereNeverServed) {
  Node node = open(Way::udp, VanillaDds::never);
  auto pub = node.publisher<PointCloud2>("points").value();
  const std::multiset<std::string> before = names_of_threads();
  Node served = open(Way::udp);
  auto other = served.publisher<PointCloud2>("points").value();
  auto sub = node.subscriber<PointCloud2>("points").value();
  expect_served(pub, 1);
  expect_served(other, 1);
  std::multiset<std::string> of_second_node = names_of_threads();
  for (const std::string& name : before) {
    if (const auto known = of_second_node.find(name); known != of_second_node.end())
      of_second_node.erase(known);
  }
  EXPECT_THAT(of_second_node, testing::Not(testing::Contains("recv"))) << "as a thread of Cyclone is called";
  EXPECT_THAT(of_second_node, testing::Not(testing::Contains(HasSubstr("dds"))));
}

TEST_F(VanillaTest, APublisherOfANodeThatServesThemNeverIsNotMatched) {
  Node node = open(Way::udp, VanillaDds::never);
  Node serving = open(Way::udp);
  auto never = node.publisher<PointCloud2>("never").value();
  auto pub = serving.publisher<PointCloud2>("points").value();
  VanillaReader of_never(network_.host(1), {.topic = "rt/never"});
  VanillaReader reader(network_.host(1), {});
  ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
  EXPECT_EQ(of_never.matched(), 0U);
  EXPECT_EQ(never.status().vanilla_readers, 0U);
}

// Otherwise a program that forwards messages of DDS to SFT would get its own messages back.
TEST_F(VanillaTest, AProgramThatSpeaksDdsItselfServesNobodyUnlessItSaysSo) {
  const dds_entity_t participant = dds_create_participant(control_domain(), nullptr, nullptr);
  Node node = open(Way::udp);
  Node serving = open(Way::udp, VanillaDds::always);
  auto automatic = node.publisher<PointCloud2>("automatic").value();
  auto pub = serving.publisher<PointCloud2>("points").value();
  VanillaReader of_automatic(network_.host(1), {.topic = "rt/automatic"});
  VanillaReader reader(network_.host(1), {});
  ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
  EXPECT_EQ(of_automatic.matched(), 0U);
  dds_delete(participant);
}

TEST_F(VanillaTest, AProgramThatHasTheLoopbackOnlyServesThemIfItSaysSo) {
  const auto host = hosts::NetworkNamespace::create().value();
  ASSERT_TRUE(host.run({"ip", "link", "set", "lo", "up"}));
  ASSERT_TRUE(host.run({"ip", "link", "set", "lo", "multicast", "on"}));
  ASSERT_TRUE(host.enter());
  Node node = open(Way::udp, VanillaDds::always);
  auto pub = node.publisher<PointCloud2>("points").value();
  VanillaReader reader(host, {});
  ASSERT_TRUE(serves(pub, 1) && reader.matches(1));
  pub.publish(cloud(3));
  EXPECT_EQ(reader.take().body, body_of(cloud(3)));
}

}  // namespace
}  // namespace sft::test
