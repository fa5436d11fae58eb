// The verbs ls, info, type and why, which show the endpoints of a domain.
#include <fstream>
#include <iomanip>
#include <iterator>
#include <nav_msgs/msg/Odometry.hpp>
#include <sstream>

#include "sft/detail/type_description.h"
#include "tests/support/isolated_host.h"
#include "tests/tools/sft/tool_fixture.h"

namespace sft::test {
namespace {

using namespace detail;

using nav_msgs::msg::Odometry;

class LookTest : public ToolTest {
 protected:
  /// Returns the id in the form in which `sft why` prints it.
  static std::string id_of(const PublisherStatus::Reader& reader) {
    std::ostringstream id;
    id << std::hex << std::setfill('0') << std::setw(16) << reader.id;
    return id.str();
  }

  Node logger = open("logger");
  Publisher<PointCloud2> points = robot.publisher<PointCloud2>("points").value();
  Subscriber<PointCloud2, F::width | F::height> monitor =
      logger.subscriber<PointCloud2, F::width | F::height>("points", {.max_rate_hz = 20}).value();
};

TEST_F(LookTest, LsListsNodesTopicsTypesAndEndpointsAsJson) {
  const Ended ended = run_tool({"ls", "--json"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json all = Json::parse(ended.out);
  EXPECT_EQ(all["domain"], robot.status().domain);
  ASSERT_EQ(all["nodes"].size(), 2U) << ended.out;
  EXPECT_EQ(all["nodes"][0]["name"], "lidar");
  EXPECT_EQ(all["nodes"][0]["publishes"], Json::array({"points"}));
  EXPECT_EQ(all["nodes"][1]["subscribes"], Json::array({"points"}));
  ASSERT_EQ(all["topics"].size(), 1U);
  EXPECT_EQ(all["topics"][0]["publishers"], 1);
  EXPECT_EQ(all["topics"][0]["subscribers"], 1);
  EXPECT_EQ(all["types"][0]["name"], "sensor_msgs/msg/PointCloud2");
  EXPECT_EQ(all["endpoints"].size(), 2U);
}

TEST_F(LookTest, LsPrintsTablesAndNamesThatFitATerminal) {
  const std::string domain = "domain " + std::to_string(robot.status().domain) + "\n";
  EXPECT_EQ(run_tool({"ls"}).out, domain +
                                      "TOPIC   TYPE                         PUBLISHERS  SUBSCRIBERS\n"
                                      "points  sensor_msgs/msg/PointCloud2  1           1\n");
  EXPECT_EQ(run_tool({"ls", "nodes"}).out, domain +
                                               "NODE    PUBLISHES  SUBSCRIBES TO\n"
                                               "lidar   points     -\n"
                                               "logger  -          points\n");
  EXPECT_EQ(run_tool({"ls", "topics", "--names"}).out, "points\n");
  EXPECT_THAT(run_tool({"ls", "types"}).out, HasSubstr("sensor_msgs/msg/PointCloud2"));
  EXPECT_THAT(run_tool({"ls", "endpoints"}).out, HasSubstr("publisher   lidar"));
}

TEST_F(LookTest, InfoTellsPoliciesWaysAndWhatIsAskedFor) {
  const Ended text = run_tool({"info", "/points"});
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("best_effort, volatile, keep last 1"));
  EXPECT_THAT(text.out, HasSubstr("asks for   height, width; at most 20 Hz"));
  EXPECT_THAT(text.out, HasSubstr("ways       udp, on this machine"));
  const Json json = Json::parse(run_tool({"info", "points", "--json"}).out);
  EXPECT_EQ(json["subscribers"][0]["fields"], "height, width");
  EXPECT_EQ(json["subscribers"][0]["qos"]["reliability"], "best_effort");
  EXPECT_EQ(json["publishers"][0]["node"], "lidar");
}

TEST_F(LookTest, TypeIsTheTextOfTheMessageFile) {
  const Ended ended = run_tool({"type", "points"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, StartsWith("# sensor_msgs/msg/PointCloud2\n"
                                    "std_msgs/Header header\n"
                                    "uint32 height\n"
                                    "uint32 width\n"
                                    "sensor_msgs/PointField[] fields\n"
                                    "bool is_bigendian\n"));
  EXPECT_THAT(ended.out,
              HasSubstr("\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"));
  EXPECT_EQ(run_tool({"type", "points", "--name"}).out, "sensor_msgs/msg/PointCloud2\n");
  EXPECT_THAT(run_tool({"type", "points", "--fields"}).out, HasSubstr("fields[].name\n"));
  EXPECT_EQ(Json::parse(run_tool({"type", "points", "--json"}).out)["fields"][0], "header.stamp.sec");
}

TEST_F(LookTest, TypeOfANameThatNoTopicHasIsTheMessageWithThatName) {
  const std::string of_topic = run_tool({"type", "points"}).out;
  for (const char* name :
       {"sensor_msgs/PointCloud2", "sensor_msgs/msg/PointCloud2", "sensor_msgs::msg::PointCloud2"}) {
    const Ended ended = run_tool({"type", name, "--wait", "0.1"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.out, of_topic) << name;
    EXPECT_EQ(ended.err, "");
  }
  const Json json = Json::parse(run_tool({"type", "std_msgs/Header", "--wait", "0.1", "--json"}).out);
  EXPECT_TRUE(json["topic"].is_null());
  EXPECT_EQ(json["type"], "std_msgs/msg/Header");
  auto odd = robot.publisher<Odometry>("std_msgs/Header").value();
  EXPECT_EQ(run_tool({"type", "std_msgs/Header", "--name"}).out, "nav_msgs/msg/Odometry\n")
      << "it is a topic";
}

TEST_F(LookTest, TypePrintsTheConstantsThatTheFilesOfTheTypeHave) {
  for (const char* const name : {"points", "sensor_msgs/PointCloud2"}) {
    EXPECT_THAT(run_tool({"type", name}).out,
                HasSubstr("\nMSG: sensor_msgs/PointField\nuint8 INT8=1\nuint8 UINT8=2\n"))
        << name;
  }
  const std::string status = run_tool({"type", "sensor_msgs/NavSatStatus"}).out;
  EXPECT_THAT(status, HasSubstr("\nint8 STATUS_NO_FIX="));
  EXPECT_LT(status.find("STATUS_NO_FIX"), status.find("int8 status\n")) << status;
}

TEST_F(LookTest, TypeKnowsServices) {
  std::ifstream file(program_directory() + "/../share/sft/interfaces/std_srvs/srv/SetBool.srv");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  ASSERT_THAT(text, HasSubstr("---\n"));
  for (const char* const name : {"std_srvs/SetBool", "std_srvs/srv/SetBool", "std_srvs::srv::SetBool"}) {
    const Ended ended = run_tool({"type", name, "--wait", "0.1"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.out, text) << name;
  }
  EXPECT_EQ(Json::parse(run_tool({"type", "std_srvs/SetBool", "--wait", "0.1", "--json"}).out)["srv"], text);
  const Ended fields = run_tool({"type", "std_srvs/SetBool", "--wait", "0.1", "--fields"});
  EXPECT_EQ(fields.code, 2);
  EXPECT_THAT(fields.err, HasSubstr("'std_srvs/SetBool' is a service, and --fields is for messages"));
}

TEST_F(LookTest, AnUnknownTypeIsOneSentenceAboutTopicsAndTypes) {
  const Ended ended = run_tool({"type", "sensor_msgs/PointCloud3", "--wait", "0.1", "--timeout", "0.1"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.err,
              StartsWith("sft: nobody publishes or subscribes to 'sensor_msgs/PointCloud3' in domain "));
  EXPECT_THAT(ended.err, HasSubstr("; as a type: "));
  EXPECT_THAT(ended.err, HasSubstr("no node announces such a type in domain "));
}

TEST_F(LookTest, WhyTellsHowAPairMatchesAndWhatBothOfItsNodesHaveCounted) {
  const Publishing publishing(points, cloud());
  EXPECT_TRUE(eventually([&] { return static_cast<bool>(monitor.take()); }));
  const Json json = Json::parse(run_tool({"why", "points", "--json", "--wait", "2"}).out);
  const Json& pair = json["pairs"].at(0);
  EXPECT_EQ(pair["matched"], true);
  EXPECT_EQ(pair["connected"], true);
  EXPECT_EQ(pair["transport"], "udp");
  EXPECT_EQ(pair["publisher"]["node"], "lidar");
  EXPECT_EQ(pair["subscriber"]["node"], "logger");
  EXPECT_EQ(pair["fields"], "height, width");
  EXPECT_EQ(pair["max_rate_hz"], 20.0);
  EXPECT_GT(pair["sent_by_publisher"]["samples"], 0);
  EXPECT_GT(pair["sent"], 0);
  EXPECT_GT(pair["withheld"], 0) << "20 of 100 samples a second are sent";
  EXPECT_EQ(pair["dropped"], 0);
  EXPECT_TRUE(pair["lost"].is_number());
  const Ended text = run_tool({"why", "points", "--wait", "30"});
  EXPECT_EQ(text.code, 0);
  EXPECT_THAT(text.out, HasSubstr("\nlidar -> logger  ("));
  EXPECT_THAT(text.out,
              HasSubstr("\n    matched by udp: the publisher or its node rules shared memory out\n"));
  EXPECT_THAT(text.out, ::testing::Not(HasSubstr("  \n"))) << "no text, no line";
}

// The reader requests two numbers of four bytes each from a cloud of 6 MB.
TEST_F(LookTest, WhyTellsWhatTwoFieldsOfALargeCloudHaveSaved) {
  PointCloud2 large = cloud();
  large.data.resize(6'000'000);
  auto all = logger.subscriber<PointCloud2, F::width | F::height>("points").value();
  std::string id;
  ASSERT_TRUE(eventually([&] {
    for (const PublisherStatus::Reader& reader : points.status().readers) {
      if (reader.served && reader.max_rate_hz == 0) id = id_of(reader);
    }
    return !id.empty();
  }));
  constexpr int samples = 10;
  for (int i = 0; i < samples; ++i) {
    points.publish(large);
    ASSERT_TRUE(all.wait(hang_timeout));
    while (all.take()) continue;
  }
  Json reported;
  ASSERT_TRUE(eventually([&] {
    const Json json = Json::parse(run_tool({"why", "points", "--json"}).out);
    for (const Json& pair : json["pairs"]) {
      if (pair["max_rate_hz"] == 0.0) reported = pair;
    }
    return reported["received"] == samples;
  })) << reported.dump(2);
  EXPECT_EQ(reported["sent"], samples);
  EXPECT_EQ(reported["withheld"], 0);
  EXPECT_EQ(reported["lost"], 0);
  EXPECT_EQ(reported["bytes_sent"], samples * 8);
  EXPECT_GT(reported["bytes_saved"], samples * 6'000'000);
  const std::string text = run_tool({"why", "points"}).out;
  const std::size_t begin = text.find("-> " + id);
  ASSERT_NE(begin, std::string::npos) << text;
  EXPECT_THAT(text.substr(begin), HasSubstr("\n    fields     height, width\n"
                                            "    sent       10 samples, 80 B over the network\n"
                                            "    saved      60 MB, 99.9998 % of the whole samples\n"
                                            "    withheld   0 samples; 0 dropped\n"
                                            "    lost       0 samples; 10 received\n"));
}

/// The subscriber cannot detect that samples are lost.
TEST_F(LookTest, WhySaysThatSamplesWereSentOfWhichTheSubscriberHasTakenNone) {
  const Publishing publishing(points, cloud());
  Ended why;
  EXPECT_TRUE(eventually([&] {
    why = run_tool({"why", "points"});
    return why.out.find("samples were sent, and the subscriber has taken none") != std::string::npos;
  })) << why.out;
  EXPECT_EQ(why.code, 1);
  EXPECT_THAT(why.out, HasSubstr("firewall"));
  EXPECT_EQ(Json::parse(run_tool({"why", "points", "--json"}).out)["pairs"].at(0)["takes_none"], true);
  EXPECT_TRUE(eventually([&] { return static_cast<bool>(monitor.take()); }));
  EXPECT_TRUE(eventually([&] { return run_tool({"why", "points"}).code == 0; }));
}

TEST_F(LookTest, WhyNamesWhatWasNotReportedYet) {
  std::string text;
  // Repeats the command, because it may end before it has discovered both endpoints.
  EXPECT_TRUE(eventually([&] {
    const Ended why = run_tool({"why", "points", "--wait", "0"});
    EXPECT_EQ(why.code, 1) << "it is not known whether samples arrive";
    text = why.out;
    return text.find("lidar -> logger") != std::string::npos;
  }));
  EXPECT_THAT(text, HasSubstr("\n    sent       not reported yet\n"
                              "    saved      not reported yet\n"
                              "    withheld   not reported yet\n"
                              "    lost       not reported yet\n"
                              "    both nodes are heard, and neither answers: "));
  Json pairs;
  EXPECT_TRUE(eventually([&] {
    pairs = Json::parse(run_tool({"why", "points", "--json", "--wait", "0"}).out)["pairs"];
    return !pairs.empty();
  }));
  for (const char* count : {"sent", "bytes_saved", "withheld", "lost"})
    EXPECT_TRUE(pairs.at(0)[count].is_null()) << count;
}

TEST_F(LookTest, WhyNamesTheReasonForWhichAnotherNodeHasNoSharedMemory) {
  NodeOptions options{.name = "camera"};
  options.shm.start_daemon = false;
  Node camera = Node::open(options).value();
  auto images = camera.publisher<PointCloud2>("images").value();
  options.name = "viewer";
  Node viewer = Node::open(options).value();
  auto subscriber = viewer.subscriber<PointCloud2>("images").value();
  std::string text;
  EXPECT_TRUE(eventually([&] {
    text = run_tool({"why", "images"}).out;
    return text.find("publisher's node: no sftd is running") != std::string::npos;
  })) << text;
}

TEST_F(LookTest, NoLineOfWhyIsLongerThanEightyColumns) {
  Node talkative = open("a_node_of_which_the_name_" + std::string(120, 'n') + "_is_long");
  auto strict = talkative.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  auto many = talkative
                  .subscriber<PointCloud2, F::header | F::height | F::width | F::fields | F::is_bigendian |
                                               F::point_step | F::row_step>("points")
                  .value();
  const std::string text = run_tool({"why", "points"}).out;
  EXPECT_THAT(text, HasSubstr("requested"));
  EXPECT_THAT(text, HasSubstr("row_step"));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
}

TEST_F(LookTest, WhyNamesThePolicyThatDoesNotFit) {
  auto strict = logger.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  const Ended text = run_tool({"why", "points"});
  EXPECT_EQ(text.code, 1);
  EXPECT_THAT(text.out, HasSubstr("not matched: incompatible QoS: reliability best_effort is offered,"));
  EXPECT_THAT(text.out, HasSubstr("requested  reliable, volatile, keep last 8"));
  const Ended json = run_tool({"why", "points", "--json"});
  EXPECT_EQ(json.code, 1);
  std::size_t incompatible = 0;
  const Json all = Json::parse(json.out);
  for (const Json& pair : all["pairs"]) incompatible += pair["incompatible_policy"] == "reliability" ? 1 : 0;
  EXPECT_EQ(incompatible, 1U);
}

TEST_F(LookTest, WhyTellsOfAnotherType) {
  auto wrong = logger.subscriber<Odometry>("points").value();
  const Ended text = run_tool({"why", "points"});
  EXPECT_EQ(text.code, 1);
  EXPECT_THAT(text.out, HasSubstr("not matched: type sensor_msgs::msg::PointCloud2 is published,\n"
                                  "    nav_msgs::msg::Odometry is subscribed to"));
}

TEST_F(LookTest, WhyTellsWhereTwoDefinitionsDiffer) {
  std::vector<Member> members(TypeTable<PointCloud2>::members.begin(), TypeTable<PointCloud2>::members.end());
  members[1].kind = Kind::uint64;
  const auto taller =
      DynamicType::parse(describe(StructType(TypeTable<PointCloud2>::type.name, members))).value();
  auto wrong = logger.subscriber("points", taller, "height").value();
  const Ended text = run_tool({"why", "points", "--types"});
  EXPECT_EQ(text.code, 1);
  EXPECT_THAT(text.out, HasSubstr("two different definitions"));
  EXPECT_THAT(text.out, HasSubstr("height: uint32 here, uint64 there\n    here: the publisher's definition"));
  EXPECT_THAT(text.out, HasSubstr("uint64 height;"));
}

TEST_F(LookTest, WhyTellsOfSharedMemory) {
  Node a = open("camera", TransportChoice::shm);
  Node b = open("viewer", TransportChoice::automatic);
  auto publisher = a.publisher<PointCloud2>("images").value();
  auto subscriber = b.subscriber<PointCloud2, F::width>("images").value();
  ASSERT_TRUE(eventually([&] {
    const auto status = publisher.status();
    return !status.readers.empty() && status.readers[0].served;
  }));
  const Json pair = Json::parse(run_tool({"why", "images", "--json"}).out)["pairs"].at(0);
  EXPECT_EQ(pair["transport"], "shm");
  EXPECT_EQ(pair["reason"], "same host");
}

TEST_F(LookTest, AnUnknownTopicIsOneSentenceThatNamesTheDomainAndTheTopicsThatAreThere) {
  const char* const chosen = std::getenv("ROS_DOMAIN_ID");
  const std::string domain = chosen == nullptr ? "0" : chosen;
  for (const char* command : {"info", "type", "echo", "hz", "bw", "delay", "why"}) {
    const Ended ended = run_tool({command, "pints", "--timeout", "0.5"});
    EXPECT_EQ(ended.code, 1) << command;
    EXPECT_EQ(ended.out, "") << command;
    EXPECT_EQ(ended.err, "sft: nobody publishes or subscribes to 'pints' in domain " + domain +
                             "; topics that were seen: points; did you mean 'points'?\n")
        << command;
  }
}

TEST_F(LookTest, ATopicWithASlashInFrontIsFoundEitherWay) {
  EXPECT_EQ(run_tool({"type", "/points", "--name"}).code, 0);
  auto slashed = robot.publisher<Odometry>("/odom").value();
  EXPECT_EQ(run_tool({"type", "/odom", "--name"}).out, "nav_msgs/msg/Odometry\n");
  EXPECT_EQ(run_tool({"type", "odom", "--name"}).out, "nav_msgs/msg/Odometry\n");
}

}  // namespace
}  // namespace sft::test
