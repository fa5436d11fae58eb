// An unmodified DDS writer on one host and an unmodified DDS reader on another host, with a bridge on each
// of the hosts.
#include <sft/json.h>
#include <sft/msg_text.h>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <std_msgs/msg/UInt32.hpp>
#include <string>
#include <vector>

#include "tests/support/pace.h"
#include "tests/support/test_seed.h"
#include "tests/support/xyz_cloud.h"
#include "tests/system/node_process.h"
#include "tests/system/vanilla_fixture.h"

namespace sft::test {
namespace {

/// A process of `sft bridge` on a host.
class BridgeProcess {
 public:
  BridgeProcess(const hosts::NetworkNamespace& host, std::vector<std::string> words) {
    const std::string program = program_directory() + "/sft";
    words.insert(words.begin(), {program, "bridge"});
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    process_ = fork();
    if (process_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (host.enter()) execv(program.c_str(), pointers.data());
    _exit(3);
  }
  ~BridgeProcess() {
    if (process_ > 0) end();
  }
  BridgeProcess(const BridgeProcess&) = delete;
  BridgeProcess& operator=(const BridgeProcess&) = delete;

  /// Ends it as Ctrl-C does, and returns its exit code.
  int end() {
    int status = 0;
    kill(process_, SIGINT);
    waitpid(std::exchange(process_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t process_ = -1;
};

/// The robot is the first host, with DDS domain 31, and the station the second one, with 32.
class BridgeOfHostsTest : public VanillaTest {
 protected:
  /// The processes of DDS take their domain from the environment.
  static void use_domain(const char* domain) { setenv("ROS_DOMAIN_ID", domain, 1); }
  static std::vector<std::string> rules_of_robot() {
    return {"--from", "31", "--to", "33", "--to-dds", "never", "points -> robot/points"};
  }
  static std::vector<std::string> rules_of_station() {
    return {"--from", "33", "--from-dds", "never", "--to", "32", "robot/points{data{x,y,z}}[::4] -> points"};
  }
  /// A node of SFT on the first host, for whom unmodified nodes of DDS are not there.
  static Node open_in(std::uint32_t domain) {
    NodeOptions options = node_options(Way::udp, "camera");
    options.domain = domain;
    options.vanilla_dds = VanillaDds::never;
    return Node::open(options).value();
  }
  /// Options of a node at the other end of the link. The hosts have one memory, which that node does not use.
  static NodeOptions behind_link(const char* name) {
    NodeOptions options{.name = name, .domain = 33};
    options.transport = TransportChoice::udp;
    options.vanilla_dds = VanillaDds::never;
    return options;
  }
  template <class... Words>
  static std::vector<std::string> into_link(Words... words) {
    return {"--from", "31", "--from-dds", "never", "--to", "33", "--to-dds", "never", words...};
  }
  void set_link(const char* state) {
    ASSERT_TRUE(network_.run_on_switch({"ip", "link", "set", network_.port(1), state}));
  }
  static std::uint32_t number_of(const VanillaReader::Sample& cloud) {
    std::uint32_t number = 0;
    if (!cloud.body.empty()) std::memcpy(&number, cloud.body.data(), sizeof number);
    return number;
  }
};

/// An unmodified writer at the robot and an unmodified reader at the station, and a bridge on each host.
class TwoBridgesTest : public BridgeOfHostsTest {
 protected:
  template <class How>
  static How in(const char* domain, const How& how) {
    use_domain(domain);
    return how;
  }

  VanillaWriter writer_{network_.host(0), in("31", VanillaWriter::How{.kind = "points"})};
  VanillaReader reader_{network_.host(1), in("32", VanillaReader::How{})};
  BridgeProcess robot_{network_.host(0), rules_of_robot()};
  BridgeProcess station_{network_.host(1), rules_of_station()};
};

TEST_F(TwoBridgesTest, CloudsOfAnUnmodifiedWriterReachAnUnmodifiedReaderBehindTwoBridges) {
  ASSERT_TRUE(writer_.matches(1) && reader_.matches(1));
  std::uint32_t number = 0;
  std::optional<Ticker> ticker(std::in_place, 50ms,
                               [&](std::uint32_t) { writer_.write_cloud(++number, points); });
  for (int i = 0; i < 5; ++i) {
    const auto sample = reader_.take();
    ASSERT_FALSE(sample.body.empty());
    const auto sent = xyz_cloud(static_cast<std::uint32_t>(sample.body[0]));
    auto expected = sent;
    expected.width = points / 4;
    expected.point_step = 12;
    expected.row_step = points / 4 * 12;
    expected.fields.resize(3);
    expected.data = thinned(sent);
    EXPECT_EQ(sample.body, body_of(expected));
  }
  ticker.reset();
  EXPECT_EQ(robot_.end(), 0);
  EXPECT_EQ(station_.end(), 0);
}

TEST_F(TwoBridgesTest, CloudsFlowAgainAfterAnOutageOfMoreThanALease) {
  Node watcher = open_in(33);
  const auto is_read = [&] {
    return std::ranges::any_of(watcher.domain().subscribers, [](const DomainSnapshot::Endpoint& one) {
      return one.topic == "robot/points";
    });
  };
  std::atomic<std::uint32_t> number{0};
  const Ticker ticker(50ms, [&](std::uint32_t next) { writer_.write_cloud(number = next, points); });
  ASSERT_FALSE(reader_.take().body.empty());
  ASSERT_TRUE(eventually(is_read));
  set_link("down");
  ASSERT_TRUE(eventually([&] { return !is_read(); }));
  set_link("up");
  const std::uint32_t at_end = number;
  std::uint32_t last = 0;
  for (std::uint32_t next = 1; next != 0 && last <= at_end; last = std::max(last, next))
    next = number_of(reader_.take());
  EXPECT_GT(last, at_end);
}

/// The routes are those of a bridge that has many.
std::vector<std::byte> routes() {
  const DynamicType type =
      from_msg("sft_bridge/Routes",
               "uint64 bridge\nsft_bridge/Route[] routes\n===\nMSG: sft_bridge/Route\nuint64 origin\n"
               "uint32 bridges\nstring topic\nuint64 publisher\n")
          .value();
  std::string list;
  for (int i = 0; i < 20; ++i)
    list += std::string(i == 0 ? "" : ",") + R"({"origin":7,"bridges":1,"topic":"points","publisher":9})";
  return cdr_from_json(type.type(), R"({"bridge":1,"routes":[)" + list + "]}").value();
}

TEST_F(TwoBridgesTest, MutatedAndCutRoutesOfAForgerStopNothing) {
  Random random(test_seed());
  const auto below = [&](std::size_t end) { return static_cast<std::size_t>(random() % end); };
  VanillaForger forger(network_.host(1), "rt/sft_bridges", "sft_bridge::msg::dds_::Routes_");
  ASSERT_TRUE(forger.is_matched());
  std::atomic<std::uint32_t> number{0};
  std::optional<Ticker> ticker(std::in_place, 50ms,
                               [&](std::uint32_t next) { writer_.write_cloud(number = next, points); });
  const std::vector<std::byte> sound = routes();
  std::uint32_t last = 0;
  for (int i = 0; i < 60; ++i) {
    for (int n = 0; n < 10; ++n) {
      std::vector<std::byte> mutated = sound;
      for (std::size_t k = below(4); k > 0; --k)
        mutated[4 + below(mutated.size() - 4)] = static_cast<std::byte>(below(256));
      if (n % 2 == 0) mutated.resize(4 + below(mutated.size() - 4));
      forger.write_sample(mutated);
    }
    const std::uint32_t next = number_of(reader_.take());
    ASSERT_GT(next, last) << how_to_repeat();
    last = next;
  }
  ticker.reset();
  EXPECT_EQ(robot_.end(), 0);
  EXPECT_EQ(station_.end(), 0);
}

using std_msgs::msg::UInt32;

/// The samples that a reader behind a narrow link has received.
struct Arrivals {
  std::atomic<bool> failed{false};
  std::atomic<std::uint32_t> bulk{0}, urgent{0}, small{0};
  std::atomic<std::uint32_t> overtaken{0};  ///< samples of "bulk" behind smaller ones that were sent later
};

void take_all(Node& node, Arrivals& arrivals) {
  auto bulk = node.subscriber<PointCloud2>("bulk").value(),
       urgent = node.subscriber<PointCloud2>("urgent").value();
  auto small = node.subscriber<UInt32>("small", {.reliability = reliable, .depth = 1000}).value();
  std::uint32_t last_small = 0;
  for (Pace pace(1ms);; pace.await_turn()) {
    while (const auto sample = small.take()) {
      last_small = sample->data();
      ++arrivals.small;
    }
    while (urgent.take()) ++arrivals.urgent;
    while (const auto sample = bulk.take()) {
      ++arrivals.bulk;
      if (last_small >= sample->height()) ++arrivals.overtaken;
    }
  }
}

/// In each moment a large sample of "bulk", then a large one of "urgent", then a small one are published. The
/// link has room for those of "urgent" only.
TEST_F(BridgeOfHostsTest, OnANarrowLinkSmallSamplesAndTheGreaterPriorityComeFirst) {
  ASSERT_TRUE(network_.run_on_switch({"tc", "qdisc", "add", "dev", network_.port(1), "root", "tbf", "rate",
                                      "20mbit", "burst", "32kb", "latency", "100ms"}));
  const NodeProcessWith<Arrivals> reader(network_.host(1), behind_link("reader"), take_all);
  BridgeProcess robot(network_.host(0), into_link("--priority", "urgent=1", "bulk", "urgent", "small"));
  Node node = open_in(31);
  auto bulk = node.publisher<PointCloud2>("bulk").value(),
       urgent = node.publisher<PointCloud2>("urgent").value();
  auto small = node.publisher<UInt32>("small", {.reliability = reliable}).value();
  ASSERT_TRUE(bulk.wait_for_subscribers(1, hang_timeout) && urgent.wait_for_subscribers(1, hang_timeout) &&
              small.wait_for_subscribers(1, hang_timeout));
  const Arrivals& arrivals = reader.report();
  std::atomic<std::uint32_t> published{0};
  const Ticker ticker(10ms, [&](std::uint32_t number) {
    bulk.publish(cloud(number, 120'000));
    urgent.publish(cloud(number, 20'000));
    small.publish({.data = number});
    published = number;
  });
  EXPECT_TRUE(eventually([&] { return arrivals.small >= 500; }));
  EXPECT_FALSE(arrivals.failed);
  EXPECT_GT(arrivals.urgent, 2 * arrivals.bulk);
  EXPECT_GT(arrivals.urgent, published / 2);
  EXPECT_GT(arrivals.overtaken, arrivals.bulk / 10 * 8);
}

struct Numbers {
  std::atomic<bool> failed{false};
  std::atomic<std::uint32_t> last{0}, count{0};
};

void count_bulk(Node& node, Numbers& numbers) {
  auto bulk = node.subscriber<PointCloud2>("bulk", {.reliability = reliable}).value();
  for (;;) {
    if (!bulk.wait(hang_timeout)) continue;
    const auto sample = bulk.take();
    ++numbers.count;
    numbers.last = sample->height();
  }
}

TEST_F(BridgeOfHostsTest, AfterAnOutageWithinALeaseFewOldSamplesOfALargeReliableTopicComeBeforeNewOnes) {
  use_lease("100 s");
  const NodeProcessWith<Numbers> reader(network_.host(1), behind_link("reader"), count_bulk);
  BridgeProcess robot(network_.host(0), into_link("--reliable", "bulk"));
  Node node = open_in(31);
  auto bulk = node.publisher<PointCloud2>("bulk", {.reliability = reliable}).value();
  ASSERT_TRUE(bulk.wait_for_subscribers(1, hang_timeout));
  const Numbers& numbers = reader.report();
  std::atomic<std::uint32_t> published{0};
  const Ticker ticker(10ms, [&](std::uint32_t number) {
    bulk.publish(cloud(number, 120'000));
    published = number;
  });
  ASSERT_TRUE(eventually([&] { return numbers.count > 10; }));
  set_link("down");
  const std::uint32_t at_begin = published, before = numbers.count;
  ASSERT_TRUE(eventually([&] { return published > at_begin + 400; }));
  const std::uint32_t at_end = published;
  set_link("up");
  ASSERT_TRUE(eventually([&] { return numbers.last > at_end; }));
  EXPECT_LT(numbers.count - before, 200U) << "8 MiB are 70 samples, and some new ones have come";
  EXPECT_FALSE(numbers.failed);
}

}  // namespace
}  // namespace sft::test
