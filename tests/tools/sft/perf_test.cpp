// `sft perf` between two programs: in shared memory, by UDP, between hosts, and with all kinds of faults.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/tools/sft/tool_fixture.h"
#include "tools/hosts/network.h"
#include "tools/perf/protocol.h"

namespace sft::test {
namespace {

class PerfTest : public ::testing::Test {
 protected:
  /// Runs ping or pub, with a partner that is there.
  static Ended measured(std::vector<std::string> arguments, const char* partner = "pong") {
    ToolProcess pong({"perf", partner});
    EXPECT_TRUE(pong.prints("waits in domain"));
    arguments.insert(arguments.begin(), "perf");
    Ended ended = run_tool(std::move(arguments));
    pong.send(SIGINT);
    const Ended served = pong.end();
    EXPECT_EQ(served.code, 0) << served.err;
    EXPECT_THAT(served.out, HasSubstr("begins: "));
    return ended;
  }
  /// Waits until a run has written the times of some samples.
  static bool has_measured(const char* file) {
    return eventually([&] {
      std::error_code none;
      return std::filesystem::file_size(file, none) > 200 && !none;
    });
  }
  static Json json_of(const Ended& ended) {
    EXPECT_TRUE(Json::accept(ended.out)) << ended.out << ended.err;
    return Json::parse(ended.out, nullptr, false);
  }
};

const std::vector<std::string> cloud{"--type", "sensor_msgs/PointCloud2", "--size", "160000"};

std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST_F(PerfTest, PingInSharedMemoryMeasuresHalfARoundTrip) {
  const Ended ended =
      measured(with({"ping", "--reliable", "--rate", "200", "--for", "2", "--loan", "--json"}, cloud));
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json json = json_of(ended);
  const Json& lane = json["lanes"][0];
  EXPECT_EQ(lane["path"], "shm") << ended.out;
  EXPECT_EQ(lane["sent"], 400);
  EXPECT_EQ(lane["returned"], 400);
  EXPECT_EQ(lane["lost_there"], 0);
  EXPECT_EQ(lane["lost_back"], 0);
  EXPECT_GT(lane["latency_s"]["p50"], 0);
  EXPECT_LE(lane["latency_s"]["p50"], lane["latency_s"]["p99"]);
  EXPECT_TRUE(lane["latency_s"]["p99.9"].is_null()) << "400 samples do not tell it";
  EXPECT_GT(lane["far"]["cpu_s"], 0);
  EXPECT_GT(lane["far"]["context_switches"], 0);
  EXPECT_GT(lane["there_s"]["p50"], 0) << "one host has one clock";
}

TEST_F(PerfTest, ASelectionTravelsBesideTheWholeMessageAndPlainSockets) {
  const Ended ended = measured(with({"ping", "--transport", "udp", "--fields", "height, width", "--beside",
                                     "udp,tcp,whole", "--rate", "100", "--for", "2", "--json"},
                                    cloud));
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json lanes = json_of(ended)["lanes"];
  ASSERT_EQ(lanes.size(), 4U) << ended.out;
  EXPECT_EQ(lanes[0]["name"], "sft");
  EXPECT_EQ(lanes[1]["name"], "whole");
  EXPECT_EQ(lanes[2]["name"], "udp");
  EXPECT_EQ(lanes[3]["name"], "tcp");
  EXPECT_LT(lanes[0]["message_bytes"], 100);
  EXPECT_GT(lanes[1]["message_bytes"], 160'000);
  EXPECT_EQ(lanes[2]["message_bytes"], lanes[0]["message_bytes"]) << "the same bytes";
  for (const Json& lane : lanes) {
    EXPECT_EQ(lane["sent"], 200) << lane;
    EXPECT_GT(lane["returned"], 150) << lane;
    EXPECT_GT(lane["latency_s"]["p50"], 0) << lane;
  }
}

TEST_F(PerfTest, BetweenTwoHostsTheInterfacesCarryThePartsOnly) {
  const auto network = hosts::EmulatedNetwork::create(2);
  if (!network) GTEST_SKIP() << network.error().message;
  ASSERT_TRUE(network->host(1).enter());
  ToolProcess pong({"perf", "pong"});
  ASSERT_TRUE(pong.prints("waits in domain"));
  ASSERT_TRUE(network->host(0).enter());
  const Ended ended =
      run_tool(with({"perf", "ping", "--reliable", "--transport", "udp", "--fields", "data{x,y}[::100]",
                     "--beside", "whole,udp", "--rate", "200", "--for", "2", "--json"},
                    cloud));
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json lanes = json_of(ended)["lanes"];
  EXPECT_EQ(lanes[0]["returned"], 400) << ended.out;
  EXPECT_GT(lanes[0]["here"]["bytes_out"], 400 * 800);
  EXPECT_LT(lanes[0]["here"]["bytes_out"], 400 * 3000);
  const std::int64_t returned = lanes[1]["returned"];
  EXPECT_GT(returned, 0);
  EXPECT_GT(lanes[1]["here"]["bytes_out"], returned * 160'000);
  EXPECT_GT(lanes[1]["far"]["bytes_out"], returned * 160'000);
}

TEST_F(PerfTest, LossIsToldAsItIs) {
  const auto network = hosts::EmulatedNetwork::create(2);
  if (!network) GTEST_SKIP() << network.error().message;
  ASSERT_TRUE(network->host(1).enter());
  ToolProcess pong({"perf", "pong"});
  ASSERT_TRUE(pong.prints("waits in domain"));
  ASSERT_TRUE(network->host(0).enter());
  ToolProcess ping({"perf", "ping", "--transport", "udp", "--rate", "1000", "--for", "5", "--json", "--raw",
                    "/tmp/raw.csv"});
  ASSERT_TRUE(has_measured("/tmp/raw.csv"));
  const std::string cable = hosts::EmulatedNetwork::port(1);
  for (int i = 0; i < 5; ++i) {
    for (const char* state : {"down", "up"})
      ASSERT_TRUE(network->run_on_switch({"ip", "link", "set", cable, state}));
  }
  const Ended ended = ping.end();
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json lane = json_of(ended)["lanes"][0];
  EXPECT_EQ(lane["sent"], 5000);
  const auto there = lane["lost_there"].get<int>(), back = lane["lost_back"].get<int>();
  EXPECT_GT(there, 0);
  EXPECT_LT(there, 4000);
  EXPECT_EQ(there + back + lane["returned"].get<int>(), 5000);
  EXPECT_EQ(lane["twice"], 0);
}

TEST_F(PerfTest, PubCountsWhatArrives) {
  const Ended ended =
      measured({"pub", "--size", "1000", "--reliable", "--rate", "500", "--for", "2", "--json"}, "sub");
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json lane = json_of(ended)["lanes"][0];
  EXPECT_EQ(lane["sent"], 1000);
  EXPECT_EQ(lane["arrived"], 1000);
  EXPECT_NEAR(lane["rate_hz"].get<double>(), 500, 50);
}

TEST_F(PerfTest, PubWithoutARateSendsAsFastAsTheOtherSideTakes) {
  const Ended ended = measured({"pub", "--size", "1000000", "--reliable", "--for", "1", "--json"}, "sub");
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json lane = json_of(ended)["lanes"][0];
  EXPECT_GT(lane["arrived"], 100) << ended.out;
  EXPECT_EQ(lane["sent"].get<int>() - lane["arrived"].get<int>(), lane["lost_there"].get<int>());
}

TEST_F(PerfTest, TerminalsShowALiveLineOnBothSides) {
  ToolProcess pong({"perf", "pong"}, ToolProcess::On::terminal);
  ASSERT_TRUE(pong.prints("waits in domain"));
  ToolProcess ping({"perf", "ping", "--for", "4"}, ToolProcess::On::terminal);
  EXPECT_TRUE(ping.prints("sft: p50 ")) << ping.out();
  EXPECT_TRUE(pong.prints(" samples in the last second")) << pong.out();
  EXPECT_TRUE(ping.prints("half a round trip: ")) << ping.out();
  EXPECT_EQ(ping.end().code, 0);
}

TEST_F(PerfTest, AnyNumberOfOtherSidesAnswers) {
  ToolProcess second({"perf", "pong"});
  ASSERT_TRUE(second.prints("waits in domain"));
  const Ended ended =
      measured({"ping", "--sides", "2", "--reliable", "--rate", "100", "--for", "1", "--json"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(json_of(ended)["sides"], 2);
  EXPECT_EQ(json_of(ended)["lanes"][0]["returned"], 200) << ended.out;
}

TEST_F(PerfTest, MoreSidesThanAreWaitedForAreCountedAsTheyAnswer) {
  ToolProcess second({"perf", "pong"});
  ASSERT_TRUE(second.prints("waits in domain"));
  const Ended ended =
      measured({"ping", "--reliable", "--beside", "udp", "--rate", "100", "--for", "1", "--json"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json json = json_of(ended);
  EXPECT_EQ(json["lanes"][0]["sent"], 100 * json["sides"].get<int>()) << ended.out;
  EXPECT_EQ(json["lanes"][1]["sent"], 100) << "a socket goes to one side";
  for (const Json& lane : json["lanes"]) EXPECT_EQ(lane["returned"], lane["sent"]) << ended.out;
}

TEST_F(PerfTest, ASlowRateLastsAsLongAsItWasToldTo) {
  struct Slow {
    const char* rate;
    int samples;
  };
  for (const auto& [rate, samples] : {Slow{"0.5", 1}, Slow{"1.5", 3}}) {
    const Ended ended = measured({"ping", "--rate", rate, "--for", "2", "--json"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(json_of(ended)["lanes"][0]["sent"], samples);
    EXPECT_NEAR(json_of(ended)["lanes"][0]["seconds"].get<double>(), 2, 0.5);
  }
}

TEST_F(PerfTest, ARunThatNeverBeginsHoldsUpNoOtherRunAndIsForgotten) {
  Node node = Node::open({.name = "lost"}).value();
  auto offers = node.publisher(perf::offer_topic, perf::text_type(), perf::retained()).value();
  auto message = node.publisher(perf::topic_of(1, "message"), perf::text_type(), perf::retained()).value();
  ASSERT_TRUE(perf::publish_text(message, "hello"));
  ToolProcess pong({"perf", "pong"});
  ASSERT_TRUE(pong.prints("waits in domain"));
  perf::Offer offer{
      .session = 1, .type = "std_msgs::msg::String", .definition = "string data\n", .fields = {"*"}};
  ASSERT_TRUE(perf::publish_text(offers, perf::text_of(offer)));
  ASSERT_TRUE(pong.prints("begins: std_msgs::msg::String")) << "its message has come";
  for (offer.session = 2; offer.session < 4; ++offer.session)
    ASSERT_TRUE(perf::publish_text(offers, perf::text_of(offer)));
  EXPECT_EQ(run_tool({"perf", "ping", "--for", "1"}).code, 0) << "while others wait for their messages";
  EXPECT_TRUE(pong.prints("cannot take part: the message did not come")) << pong.out();
  EXPECT_TRUE(pong.prints("the side that sends is gone: std_msgs::msg::String")) << pong.out();
}

TEST_F(PerfTest, ARunningTopicGivesTheMessage) {
  Node robot = Node::open({.name = "lidar"}).value();
  auto points = robot.publisher<PointCloud2>("points").value();
  const Publishing publishing(points, small_cloud("lidar", 1000), 20ms);
  const Ended ended = measured({"ping", "--like", "points", "--for", "1", "--json"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(json_of(ended)["type"], "sensor_msgs::msg::PointCloud2");
  EXPECT_GT(json_of(ended)["lanes"][0]["message_bytes"], 1000);
}

TEST_F(PerfTest, AConditionThatHoldsIsExitCodeThree) {
  const Ended ended = measured({"ping", "--for", "1", "--fail-if", "p99 > 10 s, rate > 1 Hz"});
  EXPECT_EQ(ended.code, 3);
  EXPECT_THAT(ended.err, HasSubstr("failed: rate > 1 Hz: rate is "));
  EXPECT_EQ(ended.err.find("p99"), ended.err.npos);
  EXPECT_THAT(ended.out, HasSubstr("half a round trip: min "));
}

TEST_F(PerfTest, ThePictureAndTheTimesOfEachSampleAreWritten) {
  const Ended ended = measured({"ping", "--for", "1", "--svg", "/tmp/perf.svg", "--raw", "/tmp/perf.csv"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  std::ifstream svg("/tmp/perf.svg"), raw("/tmp/perf.csv");
  const std::string picture{std::istreambuf_iterator<char>(svg), {}},
      table{std::istreambuf_iterator<char>(raw), {}};
  EXPECT_THAT(picture, HasSubstr("<polyline"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 101);
}

TEST_F(PerfTest, AFileThatCannotBeWrittenIsNamedWithTheReason) {
  for (const char* option : {"--svg", "--raw"}) {
    const Ended ended = measured({"ping", "--for", "1", option, "/dev/full"});
    EXPECT_NE(ended.code, 0) << option;
    EXPECT_THAT(ended.err, HasSubstr("'/dev/full' cannot be written: No space left on device")) << option;
  }
}

TEST_F(PerfTest, WithoutAPartnerItSaysWhatToStart) {
  const auto begin = std::chrono::steady_clock::now();
  const Ended ended = run_tool({"perf", "ping", "--timeout", "1", "--json"});
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.err, HasSubstr("0 of 1 side answered within 1 s in domain "));
  EXPECT_THAT(ended.err, HasSubstr("start 'sft perf pong' on the other machine"));
  EXPECT_FALSE(json_of(ended)["error"].is_null());
}

TEST_F(PerfTest, APartnerThatIsKilledIsNamedAndTheFiguresSoFarAreTold) {
  ToolProcess pong({"perf", "pong"});
  ASSERT_TRUE(pong.prints("waits in domain"));
  ToolProcess ping({"perf", "ping", "--for", "30", "--json", "--raw", "/tmp/live.csv"});
  ASSERT_TRUE(pong.prints("begins: "));
  ASSERT_TRUE(eventually(
      [begin = std::chrono::steady_clock::now()] { return std::chrono::steady_clock::now() - begin > 3s; }));
  pong.send(SIGKILL);
  const Ended ended = ping.end();
  EXPECT_EQ(ended.code, 1);
  EXPECT_EQ(json_of(ended)["error"], "the other side has stopped answering");
  EXPECT_GT(json_of(ended)["lanes"][0]["returned"], 0);
}

TEST_F(PerfTest, CtrlCTellsTheFiguresSoFar) {
  ToolProcess pong({"perf", "pong"});
  ASSERT_TRUE(pong.prints("waits in domain"));
  ToolProcess ping({"perf", "ping", "--reliable", "--for", "60", "--json", "--raw", "/tmp/live.csv",
                    "--fail-if", "lost > 0, lost_there > 0"});
  ASSERT_TRUE(pong.prints("begins: "));
  ASSERT_TRUE(has_measured("/tmp/live.csv"));
  ASSERT_TRUE(eventually([begin = std::chrono::steady_clock::now()] {
    return std::chrono::steady_clock::now() - begin > 500ms;
  })) << "a part of the next slice is sent";
  ping.send(SIGINT);
  const Ended ended = ping.end();
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(json_of(ended)["interrupted"], true);
  EXPECT_GT(json_of(ended)["lanes"][0]["returned"], 100);
  EXPECT_EQ(json_of(ended)["lanes"][0]["returned"], json_of(ended)["lanes"][0]["sent"]) << ended.out;
  EXPECT_EQ(json_of(ended)["lanes"][0]["arrived"], json_of(ended)["lanes"][0]["sent"]) << ended.out;
  EXPECT_TRUE(pong.prints("ends: ")) << "the other side tells its own figures";
}

TEST_F(PerfTest, WhatCannotWorkIsRefusedBeforeAnythingIsSent) {
  struct Wrong {
    std::vector<std::string> arguments;
    const char* reason;
  };
  for (const auto& [arguments, reason] :
       std::vector<Wrong>{{{"ping", "--fail-if", "p99 > 2"}, "'p99 > 2': at character 8 there is the end"},
                          {{"ping", "--type", "my_msgs/None", "--timeout", "0.5"}, "my_msgs/msg/None"},
                          {{"ping", "--type", "std_msgs/String", "--size", "10"}, "write it with --value"},
                          {{"ping", "--type", "std_msgs/String", "--value", "{date: 1}"}, "date"},
                          {{"ping", "--fields", "nothing"}, "nothing"},
                          {{"pub", "--fields", "nothing"}, "nothing"},
                          {{"ping", "--loan"}, "--loan needs messages of sensor_msgs/PointCloud2"},
                          {{"ping", "--like", "nothing", "--timeout", "0.5"}, "nothing"},
                          {{"ping", "--beside", "udp", "--sides", "2"}, "leave --sides out"},
                          {{"ping", "--rate", "0"}, "--rate"},
                          {{"dance"}, "sft perf --help"}}) {
    std::vector<std::string> words{"perf"};
    const Ended ended = run_tool(with(words, arguments));
    EXPECT_THAT(ended.code, ::testing::AnyOf(1, 2)) << ended.err;
    EXPECT_THAT(ended.err, StartsWith("sft: "));
    EXPECT_THAT(ended.err, HasSubstr(reason));
  }
}

}  // namespace
}  // namespace sft::test
