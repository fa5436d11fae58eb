// The command sft shows and serves nodes of plain DDS, which know nothing of SFT.
#include <dds/dds.h>
#include <gmock/gmock.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/support/pace.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/tool_process.h"
#include "tests/system/vanilla_fixture.h"

namespace sft::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

Json json_of(std::vector<std::string> arguments) {
  arguments.emplace_back("--json");
  const Ended ended = run_tool(std::move(arguments));
  EXPECT_THAT(ended.code, testing::AnyOf(0, 1)) << ended.err;
  return Json::parse(ended.out, nullptr, false);
}

/// Runs the command, and returns what it prints, with a blank in place of each end of a line.
std::string text_of(std::vector<std::string> arguments) {
  return std::regex_replace(run_tool(std::move(arguments)).out, std::regex("\\s+"), " ");
}

class VanillaToolsTest : public VanillaTest {
 protected:
  /// Writes clouds with increasing numbers until it is destroyed.
  class Writing {
   public:
    explicit Writing(const VanillaWriter& writer)
        : ticker_(
              std::chrono::milliseconds(50), [&writer](std::uint32_t number) { writer.write_cloud(number); },
              Keeps::rate) {}

   private:
    Ticker ticker_;
  };
  /// Waits until `sft why` shows a pair with an endpoint of DDS for which `is_it` returns true.
  template <class IsIt>
  static bool shows_pair(IsIt is_it) {
    return eventually([&] {
      const Json why = json_of({"why", "points"});
      return std::ranges::any_of(why["pairs"], [&](const Json& pair) { return pair["dds"] && is_it(pair); });
    });
  }
  static bool has_reason(const Json& pair, const std::string& part) {
    return pair["reason"].get<std::string>().find(part) != std::string::npos;
  }
};

TEST_F(VanillaToolsTest, LsAndInfoShowDdsEndpointsAsSuch) {
  Node node = open(Way::udp);
  auto pub = node.publisher<PointCloud2>("points").value();
  VanillaWriter writer(network_.host(1), {});
  VanillaReader of_host(network_.host(0), {.topic = "rt/left/scans", .reliability = "best_effort"});
  ASSERT_TRUE(eventually([&] {
    const DomainSnapshot domain = node.domain();
    return domain.publishers.size() == 2 && domain.subscribers.size() == 1;
  }));
  const Json all = json_of({"ls"});
  ASSERT_EQ(all["topics"].size(), 2U) << all;
  EXPECT_EQ(all["topics"][0]["name"], "left/scans");
  EXPECT_EQ(all["topics"][0]["types"], Json::array({"sensor_msgs/msg/PointCloud2"}));
  EXPECT_EQ(all["topics"][0]["dds_subscribers"], 1);
  EXPECT_EQ(all["topics"][1]["publishers"], 2);
  EXPECT_EQ(all["topics"][1]["dds_publishers"], 1);
  EXPECT_EQ(all["nodes"].size(), 3U);
  EXPECT_THAT(run_tool({"ls"}).out, AllOf(HasSubstr("2 (1 DDS)"), HasSubstr("left/scans")));
  EXPECT_THAT(run_tool({"ls", "endpoints"}).out, HasSubstr("left/scans  dds"));
  const std::string info = run_tool({"info", "/left/scans"}).out;
  EXPECT_THAT(info, HasSubstr("best_effort, volatile\n"));
  EXPECT_THAT(info, HasSubstr("it knows nothing of SFT"));
  EXPECT_THAT(info, HasSubstr("rt/left/scans, sensor_msgs::msg::dds_::PointCloud2_"));
  EXPECT_THAT(run_tool({"info", "points"}).out, Not(HasSubstr("types differ")));
  const Json nobody = json_of({"ls", "--dds", "never"});
  EXPECT_EQ(nobody["topics"].size(), 1U) << "that of the node of SFT";
}

TEST_F(VanillaToolsTest, ATopicOfADdsWriterIsPrintedMeasuredAndRecordedByTheTypeOfTheFiles) {
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "run.mcap").string();
  VanillaWriter writer(network_.host(1), {.durability = "latched"});
  writer.write_cloud(7);
  const Ended echo = run_tool({"echo", "points", "--once", "--json", "--fields", "height, header.frame_id"});
  ASSERT_EQ(echo.code, 0) << echo.err;
  EXPECT_EQ(Json::parse(echo.out)["height"], 7);
  EXPECT_EQ(run_tool({"type", "points", "--name"}).out, "sensor_msgs/msg/PointCloud2\n");
  const Writing more(writer);
  for (const char* verb : {"hz", "bw"}) {
    const Ended measured = run_tool({verb, "points", "--for", "3"});
    EXPECT_EQ(measured.code, 0) << measured.err;
    EXPECT_THAT(measured.out, HasSubstr("Hz")) << verb;
  }
  const Ended recorded = run_tool({"record", "points{height}", "--for", "3", "-o", file});
  EXPECT_EQ(recorded.code, 0) << recorded.err;
  const Json content = json_of({"bag", "info", file});
  EXPECT_GT(content["messages"], 10) << content;
  EXPECT_THAT(content["channels"][0]["node"].get<std::string>(), testing::StartsWith("DDS "));
}

TEST_F(VanillaToolsTest, EchoOnceWorksTheTenthTimeAsTheFirst) {
  VanillaWriter writer(network_.host(1), {.durability = "latched"});
  writer.write_cloud(7);
  for (int i = 0; i < 10; ++i) {
    const Ended echo = run_tool({"echo", "points", "--once", "--json", "--fields", "height"});
    ASSERT_EQ(echo.code, 0) << echo.err;
    EXPECT_EQ(Json::parse(echo.out)["height"], 7);
  }
}

TEST_F(VanillaToolsTest, ATypeThatNoFileDefinesIsRefusedByItsName) {
  const TemporaryDirectory folder;
  const std::filesystem::path package = folder.path() / "house_msgs" / "msg";
  VanillaWriter writer(network_.host(1), {.topic = "rt/door", .durability = "latched", .kind = "door"});
  writer.write_cloud(5);
  for (const char* verb : {"echo", "hz", "type"}) {
    const Ended refused = run_tool({verb, "door"});
    EXPECT_EQ(refused.code, 1) << verb;
    EXPECT_THAT(refused.err, AllOf(HasSubstr("'house_msgs/msg/Door'"), HasSubstr("--include"))) << verb;
  }
  std::filesystem::create_directories(package);
  std::ofstream(package / "Door.msg") << "uint32 number\n";
  const Ended echo = run_tool({"echo", "door", "--once", "--json", "--include", folder.path().string()});
  ASSERT_EQ(echo.code, 0) << echo.err;
  EXPECT_EQ(Json::parse(echo.out)["number"], 5);
}

TEST_F(VanillaToolsTest, PubWaitsForADdsReaderAndServesIt) {
  VanillaReader reader(network_.host(1), {});
  for (const char* type : {"sensor_msgs/PointCloud2", "auto"}) {
    const Ended ended = run_tool({"pub", "points", type, "{height: 3}", "--once"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("1 subscriber now"));
    PointCloud2 expected;
    expected.height = 3;
    EXPECT_EQ(reader.take().body, body_of(expected));
  }
}

TEST_F(VanillaToolsTest, WithPlainNamesNeitherTheTopicsOfSftItselfNorTheGraphOfRosAreShown) {
  setenv("SFT_DDS_NAMES", "plain", 1);
  Node node = open(Way::udp, VanillaDds::always);
  auto sub = node.subscriber<PointCloud2>("scans").value();
  const VanillaForger of_ros(network_.host(1), "ros_discovery_info",
                             "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_");
  VanillaForger forger(network_.host(1), "scans", "sensor_msgs::msg::PointCloud2");
  ASSERT_TRUE(forger.is_matched());
  EXPECT_TRUE(eventually([&] {
    const Json why = json_of({"why", "scans"});
    return why["pairs"].size() == 1 && why["pairs"][0]["dds"] == true && why["pairs"][0]["connected"] == true;
  }));
  const Json all = json_of({"ls"});
  unsetenv("SFT_DDS_NAMES");
  ASSERT_EQ(all["topics"].size(), 1U) << all;
  EXPECT_EQ(all["topics"][0]["name"], "scans");
  EXPECT_EQ(all["topics"][0]["dds_publishers"], 1);
}

TEST_F(VanillaToolsTest, PubSaysWhyADdsReaderIsNotServed) {
  VanillaReader latched(network_.host(1), {.durability = "latched"});
  const Ended ended = run_tool({"pub", "points", "auto", "{height: 3}", "--once", "--timeout", "2"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("a reader of DDS is not served"), HasSubstr("durability")));
}

TEST_F(VanillaToolsTest, WhyTellsOfEachDdsEndpointWhetherItMatches) {
  Node node = Node::open(options_with_log()).value();
  auto sub = node.subscriber<PointCloud2>("points", {.selection = "@ height > 3"}).value();
  {
    VanillaWriter writer(network_.host(1), {});
    ASSERT_TRUE(writer.matches(1));
    writer.write_cloud(4);
    ASSERT_TRUE(sub.wait(hang_timeout));
    (void)sub.take();
    EXPECT_TRUE(shows_pair([](const Json& pair) {
      return pair["transport"] == "dds" && pair["received"] == 1 &&
             has_reason(pair, "applied at the subscriber") && has_reason(pair, "unverified");
    }));
  }
  const std::pair<const char*, const char*> unheard[] = {{"xcdr2", "XCDR2"},
                                                         {"partition", "'left'"},
                                                         {"other_type", "std_msgs::msg::dds_::Header_"},
                                                         {"other_hash", "RIHS01_0"}};
  for (const auto& [kind, reason] : unheard) {
    const VanillaWriter writer(network_.host(1), {.kind = kind});
    EXPECT_TRUE(shows_pair([part = reason](const Json& pair) {
      return pair["matched"] == false && has_reason(pair, part);
    })) << kind;
  }
}

TEST_F(VanillaToolsTest, WhySaysThatSamplesCameAndCannotBeRead) {
  Node node = Node::open(options_with_log()).value();
  auto sub = node.subscriber<PointCloud2>("points").value();
  VanillaForger forger(network_.host(1));
  ASSERT_TRUE(forger.is_matched());
  forger.write_sample(std::vector<std::byte>(200, std::byte{0}));  // its head says that it is big-endian
  EXPECT_TRUE(eventually([&] { return sub.status().discarded == 1; }));
  EXPECT_TRUE(eventually([&] {
    const std::string why = text_of({"why", "points"});
    return why.find("none was taken") != why.npos && why.find("big-endian") != why.npos;
  }));
}

TEST_F(VanillaToolsTest, WhyTellsWhatDdsReadersAndWritersOfOneTopicCost) {
  Node node = open(Way::udp);
  auto pub = node.publisher<PointCloud2>("points").value();
  auto sub = node.subscriber<PointCloud2>("points").value();
  VanillaReader reader(network_.host(1), {});
  ASSERT_TRUE(pub.wait_for_subscribers(2, hang_timeout));
  EXPECT_TRUE(json_of({"why", "points"})["whole_messages_by_dds"].is_null());
  VanillaWriter writer(network_.host(1), {});
  ASSERT_TRUE(writer.matches(2));
  EXPECT_THAT(text_of({"why", "points"}),
              AllOf(HasSubstr("whole messages by DDS"), HasSubstr("matched by dds")));
}

TEST_F(VanillaToolsTest, WhyNamesANodeOfSftThatLeavesDdsAlone) {
  Node node = open(Way::udp, VanillaDds::never);
  auto pub = node.publisher<PointCloud2>("points").value();
  VanillaReader reader(network_.host(1), {});
  EXPECT_TRUE(shows_pair([](const Json& pair) {
    return pair["matched"] == true && pair["connected"] == false && has_reason(pair, "has no DDS writer");
  }));
}

TEST_F(VanillaToolsTest, WhyAndDoctorNameADdsNodeThatAnnouncesNothing) {
  Node node = open(Way::udp);
  auto pub = node.publisher<PointCloud2>("points").value();
  const dds_entity_t silent = dds_create_participant(VanillaProcess::domain(), nullptr, nullptr);
  ASSERT_GT(silent, 0);
  EXPECT_THAT(text_of({"why", "points"}), HasSubstr("vanilla_tools_t"));
  EXPECT_THAT(json_of({"why", "points"})["out_of_reach"].dump(), HasSubstr("has announced no reader"));
  EXPECT_THAT(text_of({"doctor", "--quiet"}), HasSubstr("has announced no reader"));
  dds_delete(silent);
}

TEST_F(VanillaToolsTest, DoctorNamesWhatPutsDdsNodesOutOfReach) {
  const auto warnings = [] {
    std::string texts;
    const Json found = json_of({"doctor"});
    for (const Json& check : found["checks"])
      if (check["check"] == "dds" && check["health"] == "warning") texts += check["text"].get<std::string>();
    return texts;
  };
  EXPECT_EQ(warnings(), "");
  setenv("ROS_DISCOVERY_SERVER", "127.0.0.1:11811", 1);
  setenv("FASTDDS_BUILTIN_TRANSPORTS", "SHM", 1);
  setenv("ROS_SECURITY_ENABLE", "true", 1);
  setenv("RMW_IMPLEMENTATION", "rmw_zenoh_cpp", 1);
  EXPECT_THAT(warnings(), AllOf(HasSubstr("127.0.0.1:11811"), HasSubstr("'SHM'"), HasSubstr("'true'"),
                                HasSubstr("rmw_zenoh_cpp")));
  EXPECT_EQ(run_tool({"doctor"}).code, 1);
}

}  // namespace
}  // namespace sft::test
