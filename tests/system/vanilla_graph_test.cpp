// Nodes of SFT are in the graph of ROS 2: programs without SFT see the names of these nodes, and their
// publishers and subscribers with type, hash and QoS. SFT also knows the names of nodes of ROS 2.
#include <gmock/gmock.h>

#include <cstdint>

#include "core/vanilla/participant_entities.h"
#include "tests/support/test_seed.h"
#include "tests/system/node_process.h"
#include "tests/system/vanilla_fixture.h"

namespace sft::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// A process of ros_node.
class RosNode : public VanillaProcess {
 public:
  struct How {
    int guid_bytes = 16;
    std::string name_space = "/", name = "talker", topic = "rt/talk";
  };
  RosNode(const hosts::NetworkNamespace& host, const How& how)
      : VanillaProcess(host, "ros_node_" + std::to_string(how.guid_bytes),
                       {how.name_space, how.name, how.topic}) {}

  void speak() const { write_all("speak\n", 6); }
  /// Returns what tools of ROS 2 would show of other processes.
  std::vector<std::string> list() {
    write_all("list\n", 5);
    std::vector<std::string> lines;
    for (std::string line = next_line(); !line.empty() && line != "end"; line = next_line())
      lines.push_back(line);
    return lines;
  }
  bool sees(const std::string& line) {
    return eventually([&] { return std::ranges::count(list(), line) == 1; }, hang_timeout, pause);
  }
  bool sees_no_more(const std::string& line) {
    return eventually([&] { return std::ranges::count(list(), line) == 0; }, hang_timeout, pause);
  }

 private:
  static constexpr std::chrono::milliseconds pause{10};
  std::string next_line() {
    std::string line;
    for (char c = 0; read_all(&c, 1) && c != '\n';) line += c;
    return line;
  }
};

/// A process of vanilla_forger that writes what nodes of ROS 2 tell.
class ForgedTalk : public VanillaProcess {
 public:
  explicit ForgedTalk(const hosts::NetworkNamespace& host)
      : VanillaProcess(host, "vanilla_forger",
                       {"ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_"}) {}
  bool is_matched() {
    std::uint32_t matched = 0;
    return is_readable(hang_timeout) && read_all(&matched, sizeof matched);
  }
  void write_body(const std::vector<std::byte>& body) const {
    const auto size = static_cast<std::uint32_t>(body.size() + 4);
    constexpr std::uint8_t encapsulation[4] = {0, 1, 0, 0};
    write_all(&size, sizeof size);
    write_all(encapsulation, sizeof encapsulation);
    write_all(body.data(), body.size());
  }
};

class VanillaGraphTest : public VanillaTest {
 protected:
  ~VanillaGraphTest() override { unsetenv("ROS_DISTRO"); }

  /// Returns a line of RosNode::list() about an endpoint for clouds.
  static std::string line(const std::string& role_and_topic, const std::string& qos,
                          const std::string& node) {
    return role_and_topic + " sensor_msgs::msg::dds_::PointCloud2_ " + qos +
           " RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5 " + node;
  }
  static std::string name_of_writer(const Subscriber<PointCloud2>& subscriber) {
    const SubscriberStatus status = subscriber.status();
    return status.writers.empty() ? "" : status.writers.front().node;
  }
};

class VanillaGraphOfSizeTest : public VanillaGraphTest, public testing::WithParamInterface<int> {};

TEST_P(VanillaGraphOfSizeTest, ShowsANodeWithItsPublishersAndSubscribersAlsoToLateNodes) {
  RosNode ros(network_.host(1), {.guid_bytes = GetParam()});
  ros.speak();
  NodeOptions options = node_options(Way::udp, "camera");
  options.namespace_ = "left";
  Node node = Node::open(options).value();
  auto pub = node.publisher<PointCloud2>("points", {.durability = transient_local}).value();
  auto sub = node.subscriber<PointCloud2>("/clouds", {.reliability = reliable}).value();
  RosNode late(network_.host(0), {.guid_bytes = GetParam(), .name = "late"});
  for (RosNode* other : {&ros, &late}) {
    EXPECT_TRUE(other->sees("node /left/camera"));
    EXPECT_TRUE(other->sees(line("writer rt/left/points", "reliable latched -", "/left/camera")));
    EXPECT_TRUE(other->sees(line("reader rt/clouds", "reliable volatile sft_presence", "/left/camera")));
  }
}

TEST_P(VanillaGraphOfSizeTest, FollowsThePublishersAndNodesOfAProcess) {
  RosNode ros(network_.host(1), {.guid_bytes = GetParam()});
  ros.speak();
  Node camera = open(Way::udp);
  auto pub = camera.publisher<PointCloud2>("points").value();
  std::optional<Node> lidar = Node::open(node_options(Way::udp, "lidar")).value();
  {
    auto of_lidar = lidar->publisher<PointCloud2>("scan").value();
    auto further = camera.publisher<PointCloud2>("further").value();
    EXPECT_TRUE(ros.sees("node /camera"));
    EXPECT_TRUE(ros.sees("node /lidar"));
    EXPECT_TRUE(ros.sees(line("writer rt/points", "reliable volatile -", "/camera")));
    EXPECT_TRUE(ros.sees(line("writer rt/scan", "reliable volatile -", "/lidar")));
    EXPECT_TRUE(ros.sees(line("writer rt/further", "reliable volatile -", "/camera")));
  }
  EXPECT_TRUE(ros.sees_no_more(line("writer rt/further", "reliable volatile -", "/camera")));
  EXPECT_TRUE(ros.sees_no_more("node /lidar")) << "it has neither publishers nor subscribers";
  lidar.reset();
  EXPECT_TRUE(ros.sees("node /camera"));
  EXPECT_TRUE(ros.sees(line("writer rt/points", "reliable volatile -", "/camera")));
}

TEST_P(VanillaGraphOfSizeTest, HasTheNamesOfItsNodesForSubscribersAsLongAsTheyAreThere) {
  Node node = open(Way::udp);
  auto sub = node.subscriber<PointCloud2>("points").value();
  const auto driver = [&](const char* name_space, const char* name) {
    return RosNode::How{
        .guid_bytes = GetParam(), .name_space = name_space, .name = name, .topic = "rt/points"};
  };
  RosNode ros(network_.host(1), driver("/front", "driver"));
  EXPECT_TRUE(eventually([&] { return name_of_writer(sub).starts_with("DDS "); }));
  ros.speak();
  EXPECT_TRUE(eventually([&] { return name_of_writer(sub) == "/front/driver"; }));
  ros.kill_now();
  EXPECT_TRUE(eventually([&] { return sub.status().writers.empty(); }));
  RosNode other(network_.host(0), driver("/", "other_driver"));
  other.speak();
  EXPECT_TRUE(eventually([&] { return name_of_writer(sub) == "/other_driver"; }));
}

INSTANTIATE_TEST_SUITE_P(With, VanillaGraphOfSizeTest, testing::Values(16, 24), [](const auto& one) {
  return one.param == 16 ? "guids_of_16_bytes" : "guids_of_24_bytes";
});

TEST_F(VanillaGraphTest, ShowsNoNodeBeforeTheSizeIsKnownAndItsPublishersNevertheless) {
  RosNode ros(network_.host(1), {});
  Node node = open(Way::udp);
  auto pub = node.publisher<PointCloud2>("points").value();
  EXPECT_TRUE(ros.sees(line("writer rt/points", "reliable volatile -", "")));
  EXPECT_THAT(ros.list(), Not(Contains("node /camera")));
  ros.speak();
  EXPECT_TRUE(ros.sees("node /camera"));
  EXPECT_TRUE(ros.sees(line("writer rt/points", "reliable volatile -", "/camera")));
}

TEST_F(VanillaGraphTest, HasTheSizeOfTheDistributionThatTheEnvironmentNamesAndOfTheOneThatIsThereBeforeThat) {
  setenv("ROS_DISTRO", "humble", 1);
  RosNode silent(network_.host(1), {.guid_bytes = 24});
  Node node = open(Way::udp);
  auto pub = node.publisher<PointCloud2>("points").value();
  EXPECT_TRUE(silent.sees("node /camera"));
  RosNode later(network_.host(1), {.guid_bytes = 16});
  later.speak();
  EXPECT_TRUE(later.sees("node /camera"));
}

TEST_F(VanillaGraphTest, HasNoNodesOfSftWhileItsOtherNodesUseBothSizesAndTheLogSaysSo) {
  RosNode ros(network_.host(1), {});
  ros.speak();
  Node node = Node::open(options_with_log()).value();
  auto pub = node.publisher<PointCloud2>("points").value();
  EXPECT_TRUE(ros.sees("node /camera"));
  RosNode older(network_.host(1), {.guid_bytes = 24});
  older.speak();
  EXPECT_TRUE(warns_of("nodes of ROS 2 up to Humble and later ones are in DDS domain"));
  RosNode late(network_.host(1), {});
  EXPECT_TRUE(late.sees(line("writer rt/points", "reliable volatile -", "")));
  EXPECT_THAT(late.list(), Not(Contains("node /camera")));
  older.end();
  EXPECT_TRUE(late.sees("node /camera"));
  EXPECT_EQ(warnings_with("nodes of ROS 2"), 1);
}

TEST_F(VanillaGraphTest, ShowsASubscriberInThePartitionOfWritersOnlyWhileOneIsThere) {
  RosNode ros(network_.host(1), {});
  ros.speak();
  Node node = open(Way::udp);
  auto sub = node.subscriber<PointCloud2>("points").value();
  const std::string alone = line("reader rt/points", "best_effort volatile sft_presence", "/camera");
  const std::string hearing = line("reader rt/points", "best_effort volatile -", "/camera");
  EXPECT_TRUE(ros.sees(alone));
  VanillaWriter writer(network_.host(1), {});
  ASSERT_TRUE(writer.matches(1));
  EXPECT_TRUE(ros.sees(hearing));
  EXPECT_TRUE(ros.sees_no_more(alone));
  writer.end();
  EXPECT_TRUE(ros.sees(alone));
  EXPECT_TRUE(ros.sees_no_more(hearing));
}

struct Nothing {
  std::atomic<bool> failed{false};
};

/// A process with a publisher of clouds that publishes none.
NodeProcessWith<Nothing>::Role publishes_nothing() {
  return [](Node& node, Nothing&) {
    auto pub = node.publisher<PointCloud2>("scan").value();
    for (;;) pause();
  };
}

TEST_F(VanillaGraphTest, LosesANodeThatWasKilled) {
  RosNode ros(network_.host(0), {});
  ros.speak();
  NodeProcessWith<Nothing> process(network_.host(1), node_options(Way::udp, "camera"), publishes_nothing());
  EXPECT_TRUE(ros.sees("node /camera"));
  process.kill_now();
  EXPECT_TRUE(ros.sees_no_more("node /camera"));
  Node node = open(Way::udp);
  auto pub = node.publisher<PointCloud2>("points").value();
  EXPECT_TRUE(ros.sees(line("writer rt/points", "reliable volatile -", "/camera")));
}

// Two processes of SFT would keep a size for each other after the last node of ROS 2 with that size has gone.
TEST_F(VanillaGraphTest, DoesNotLearnTheSizeFromOtherProcessesOfSft) {
  setenv("ROS_DISTRO", "humble", 1);
  NodeProcessWith<Nothing> lidar(network_.host(1), node_options(Way::udp, "lidar"), publishes_nothing());
  unsetenv("ROS_DISTRO");
  Node node = open(Way::udp);
  auto pub = node.publisher<PointCloud2>("points").value();
  RosNode ros(network_.host(1), {.guid_bytes = 24});
  EXPECT_TRUE(ros.sees("node /lidar"));
  EXPECT_TRUE(ros.sees(line("writer rt/points", "reliable volatile -", "")));
  RosNode late(network_.host(0), {.guid_bytes = 24});
  EXPECT_TRUE(late.sees("node /lidar"));
  EXPECT_THAT(late.list(), Not(Contains("node /camera")));
  late.speak();
  EXPECT_TRUE(ros.sees("node /camera"));
}

TEST_F(VanillaGraphTest, SurvivesForgedMessages) {
  Node node = open(Way::udp);
  auto pub = node.publisher<PointCloud2>("points").value();
  ForgedTalk forger(network_.host(1));
  ASSERT_TRUE(forger.is_matched());
  Random random(test_seed());
  const core::ParticipantEntities sound{
      .participant = {1}, .nodes = {{.name_space = "/", .name = "a", .readers = {{1}}, .writers = {{2}}}}};
  for (int round = 0; round < 500; ++round) {
    const auto size = round % 2 == 0 ? core::GuidBytes::as_of_iron : core::GuidBytes::before_iron;
    std::vector<std::byte> body = core::encode_entities(sound, size);
    body[random() % body.size()] = static_cast<std::byte>(random());
    if (round % 100 == 0) body.resize(2'000'000);
    forger.write_body(body);
  }
  RosNode ros(network_.host(1), {});
  ros.speak();
  EXPECT_TRUE(ros.sees("node /camera"));
  forger.end();
  EXPECT_TRUE(ros.sees("node /camera"));
}

}  // namespace
}  // namespace sft::test
