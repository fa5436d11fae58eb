// The verb pub. It publishes messages that are given as text.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <std_msgs/msg/UInt32.hpp>

#include "sft/detail/type_description.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"
#include "tests/support/tame_value.h"
#include "tests/tools/sft/tool_fixture.h"

namespace sft::test {
namespace {

using std_msgs::msg::UInt32;

class PubTest : public ToolTest {
 protected:
  /// Waits for the next sample and returns it.
  template <class S>
  static auto next(S& subscriber) {
    subscriber.wait(10s);
    return subscriber.take();
  }
  /// Waits for the next `count` numbers and returns them. Returns fewer numbers if no more arrive.
  template <class S>
  static std::vector<std::uint32_t> next(S& subscriber, std::size_t count) {
    std::vector<std::uint32_t> numbers;
    while (numbers.size() < count) {
      const auto sample = next(subscriber);
      if (!sample) break;
      numbers.push_back(sample->data());
    }
    return numbers;
  }

  Subscriber<UInt32> numbers =
      robot.subscriber<UInt32>("numbers", {.reliability = reliable, .depth = 1000}).value();
};

TEST_F(PubTest, ACompiledSubscriberGetsWhatIsWrittenDown) {
  auto points = robot.subscriber<PointCloud2>("points").value();
  const Ended ended = run_tool({"pub", "/points", "sensor_msgs/msg/PointCloud2", "--once",
                                "{header: {frame_id: lidar}, width: 3, fields: [{name: x}, {name: y}]}"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.out, "points: 1 sample of sensor_msgs/msg/PointCloud2; 1 subscriber now\n");
  const auto sample = next(points);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->header().frame_id(), "lidar");
  EXPECT_EQ(sample->width(), 3U);
  EXPECT_EQ(sample->fields()[1].name(), "y");
}

TEST_F(PubTest, WithoutAValueAllIsZeroAndEmpty) {
  auto points = robot.subscriber<PointCloud2>("points").value();
  EXPECT_EQ(run_tool({"pub", "points", "sensor_msgs/PointCloud2", "--once"}).code, 0);
  const auto sample = next(points);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample.to_owned(), PointCloud2());
}

TEST_F(PubTest, InSharedMemoryToo) {
  Node viewer = open("viewer", TransportChoice::shm);
  auto points = viewer.subscriber<PointCloud2>("images").value();
  ASSERT_TRUE(eventually([&] { return viewer.status().shm_ready; }));
  const Ended ended =
      run_tool({"pub", "images", "sensor_msgs/PointCloud2", "width: 3", "-n", "5", "-r", "100"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  for (int i = 0; i < 5; ++i) {
    const auto sample = next(points);
    ASSERT_TRUE(sample) << i;
    EXPECT_EQ(sample.info().transport, TransportKind::shm);
    EXPECT_EQ(sample->width(), 3U);
  }
}

TEST_F(PubTest, EachSampleHasItsOwnTimeWhereAHeaderIsAuto) {
  auto points = robot.subscriber<PointCloud2>("points").value();
  const auto before = std::chrono::system_clock::now();
  EXPECT_EQ(
      run_tool({"pub", "points", "sensor_msgs/PointCloud2", "header: auto", "-n", "2", "-r", "50"}).code, 0);
  const auto first = next(points);
  const auto second = next(points);
  ASSERT_TRUE(first && second);
  EXPECT_GE(to_time(first->header().stamp()), before);
  EXPECT_GE(to_time(second->header().stamp()) - to_time(first->header().stamp()), 10ms);
}

TEST_F(PubTest, ItPublishesSoManyAtTheRateAndTellsItAsJson) {
  const auto begun = std::chrono::steady_clock::now();
  const Ended ended = run_tool(
      {"pub", "numbers", "std_msgs/UInt32", "data: 7", "--reliable", "-n", "21", "-r", "40", "--json"});
  EXPECT_GE(std::chrono::steady_clock::now() - begun, 500ms);
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(next(numbers, 21), std::vector<std::uint32_t>(21, 7));
  const Json json = Json::parse(ended.out);
  EXPECT_EQ(json["topic"], "numbers");
  EXPECT_EQ(json["type"], "std_msgs/msg/UInt32");
  EXPECT_EQ(json["published"], 21);
  EXPECT_EQ(json["dropped"], 0);
  EXPECT_EQ(json["subscribers"][0]["node"], "lidar");
  EXPECT_EQ(json["subscribers"][0]["sent"], 21);
}

TEST_F(PubTest, ALateSubscriberGetsTheLastSampleOfATransientLocalPublisher) {
  ToolProcess pub(
      {"pub", "map", "std_msgs/UInt32", "data: 5", "-r", "0.01", "--transient-local", "--reliable"});
  ASSERT_TRUE(eventually([&] { return robot.find_type("map", 0s).has_value(); }));
  auto late =
      robot.subscriber<UInt32>("map", {.reliability = reliable, .durability = transient_local}).value();
  EXPECT_EQ(next(late, 1), std::vector<std::uint32_t>{5});
}

TEST_F(PubTest, WhatIsWrongInTheValueIsNamedByItsPathBeforeAnythingIsPublished) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"data: -1", "sft: 'data' is -1; an integer from 0 to 4294967295 was expected\n"},
      {"dat: 1", "sft: 'dat' is no member of std_msgs::msg::UInt32; did you mean 'data'?\n"},
      {"data: [1", "sft: this is no YAML in line 1, column 1: end of sequence flow not found\n"},
      {"seven",
       "sft: the message is \"seven\"; an object with the members of std_msgs::msg::UInt32 was expected\n"}};
  for (const auto& [value, complaint] : wrong) {
    const Ended ended = run_tool({"pub", "numbers", "std_msgs/UInt32", value, "--once", "--reliable"});
    EXPECT_EQ(ended.code, 2) << value;
    EXPECT_EQ(ended.out, "");
    EXPECT_EQ(ended.err, complaint);
  }
  EXPECT_EQ(run_tool({"pub", "numbers", "std_msgs/UInt32", "data: 5", "--once", "--reliable"}).code, 0);
  EXPECT_EQ(next(numbers, 1), std::vector<std::uint32_t>{5}) << "that is the first one";
}

TEST_F(PubTest, DocumentsOfTheStandardInputArePublishedOneAfterTheOther) {
  const std::string input = "data: 1\n---\n{\"data\": 2}\n{\"data\": 3}\n---\ndata: 4\n---\n---\n{data: 5}";
  const Ended ended = run_tool({"pub", "numbers", "std_msgs/UInt32", "-", "--reliable"}, input);
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(next(numbers, 5), (std::vector<std::uint32_t>{1, 2, 3, 4, 5}));
}

TEST_F(PubTest, ADocumentIsPublishedAsSoonAsItIsComplete) {
  ToolProcess pub({"pub", "numbers", "std_msgs/UInt32", "-", "--reliable"});
  pub.feed("data: 1\n---\ndata:");
  EXPECT_EQ(next(numbers, 1), std::vector<std::uint32_t>{1});
  pub.feed(" 2\n---\n");
  EXPECT_EQ(next(numbers, 1), std::vector<std::uint32_t>{2});
  pub.end_input();
  EXPECT_EQ(pub.end().code, 0);
}

TEST_F(PubTest, SamplesThatAreLateAreNotMadeUpFor) {
  ToolProcess pub({"pub", "numbers", "std_msgs/UInt32", "-", "--reliable", "-r", "40"});
  pub.feed("data: 1\n---\n");
  EXPECT_EQ(next(numbers, 1), std::vector<std::uint32_t>{1});
  const auto half_a_second =
      run_tool({"pub", "others", "std_msgs/UInt32", "data: 0", "-n", "21", "-r", "40", "--wait-for", "0"});
  EXPECT_EQ(half_a_second.code, 0) << half_a_second.err;
  const auto begun = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i) pub.feed("data: 2\n---\n");
  EXPECT_EQ(next(numbers, 20), std::vector<std::uint32_t>(20, 2));
  EXPECT_GE(std::chrono::steady_clock::now() - begun, 300ms);
}

TEST_F(PubTest, ABadDocumentIsNamedByItsNumber) {
  const Ended ended = run_tool({"pub", "numbers", "std_msgs/UInt32", "-", "--reliable"},
                               "data: 1\n---\ndata: x\n---\ndata: 3\n");
  EXPECT_EQ(ended.code, 2);
  EXPECT_EQ(ended.err,
            "sft: document 2 of the input: 'data' is \"x\"; an integer from 0 to 4294967295 was expected\n");
}

TEST_F(PubTest, WhereNoSubscriberComesInTimeNothingIsPublishedAndTheReasonIsNamed) {
  EXPECT_EQ(run_tool({"pub", "nobody", "std_msgs/UInt32", "--once", "--timeout", "0.5"}).err,
            "sft: Nothing was published: 0 of 1 subscriber of 'nobody' came within 0.5 s in domain " +
                std::to_string(robot.status().domain) + ".\n");
  const Ended ended = run_tool({"pub", "numbers", "std_msgs/UInt32", "--once", "--timeout", "1"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.err, HasSubstr("node 'lidar' is not served: incompatible QoS: reliability best_effort is "
                                   "offered, reliable is requested"));
  EXPECT_EQ(run_tool({"pub", "nobody", "std_msgs/UInt32", "--once", "--wait-for", "0"}).code, 0);
}

TEST_F(PubTest, AnUnknownTypeIsExitCodeOneAndATypeOfAnotherNodeIsFound) {
  const Ended unknown = run_tool({"pub", "points", "my_msgs/Status", "--once", "--timeout", "0.5"});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_THAT(unknown.err, HasSubstr("there is no my_msgs/msg/Status.msg below "));
  EXPECT_THAT(unknown.err, HasSubstr("no node announces such a type"));
  const DynamicType status = from_msg("my_msgs/Status", "uint32 code\n").value();
  auto statuses = robot.subscriber("statuses", status, "*").value();
  for (const char* type : {"my_msgs/Status", "my_msgs::msg::Status", "auto"}) {
    EXPECT_EQ(run_tool({"pub", "statuses", type, "code: 3", "--once"}).code, 0) << type;
    const DynamicSample sample = next(statuses);
    ASSERT_TRUE(sample) << type;
    EXPECT_EQ(sample.to_json().value(), R"({"code":3})");
  }
}

TEST_F(PubTest, ATypeMayBeAFileThatNestsWhatIsInstalledOrIncluded) {
  namespace fs = std::filesystem;
  const fs::path root = fs::temp_directory_path() / ("sft_pub_" + std::to_string(getpid()));
  fs::create_directories(root / "my_msgs/msg");
  std::ofstream(root / "my_msgs/msg/Status.msg") << "std_msgs/Header header\nuint32 code\n";
  const std::string file = root / "my_msgs/msg/Status.msg";
  EXPECT_EQ(run_tool({"pub", "statuses", file, "{header: auto, code: 3}", "--once", "-w", "0"}).code, 0);
  const std::vector<std::string> by_name{"pub", "statuses", "my_msgs/Status", "--once", "-w", "0",
                                         "-I",  root};
  EXPECT_EQ(run_tool(by_name).code, 0);
  std::ofstream(root / "my_msgs/msg/Status.msg") << "flaot32 x\n";
  const Ended bad = run_tool({"pub", "statuses", file, "--once"});
  EXPECT_EQ(bad.code, 2);
  EXPECT_THAT(bad.err, HasSubstr("Status.msg:1: "));
  fs::remove_all(root);
}

TEST_F(PubTest, CtrlCEndsItAndSubscribersSeeItGo) {
  ToolProcess pub({"pub", "numbers", "std_msgs/UInt32", "data: 1", "-r", "100", "--reliable"});
  ASSERT_TRUE(numbers.wait(10s));
  pub.send(SIGINT);
  const Ended ended = pub.end();
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, StartsWith("numbers: "));
  EXPECT_TRUE(eventually([&] { return numbers.status().writers.empty(); }));
}

TEST_F(PubTest, CtrlCEndsItWhileItWaits) {
  ToolProcess waits({"pub", "nobody", "std_msgs/UInt32", "--once", "--timeout", "600"});
  ToolProcess reads({"pub", "numbers", "std_msgs/UInt32", "-", "--reliable"});
  ASSERT_TRUE(eventually([&] { return robot.find_type("nobody", 0s).has_value(); }));
  ASSERT_TRUE(eventually([&] { return !numbers.status().writers.empty(); }));
  for (ToolProcess* tool : {&waits, &reads}) {
    tool->send(SIGINT);
    EXPECT_EQ(tool->end().code, 1);
  }
}

TEST_F(PubTest, AfterAKillTheNextOneIsHeard) {
  ToolProcess pub({"pub", "numbers", "std_msgs/UInt32", "data: 1", "-r", "100", "--reliable"});
  ASSERT_TRUE(numbers.wait(10s));
  pub.send(SIGKILL);
  EXPECT_EQ(pub.end().code, -SIGKILL);
  EXPECT_EQ(run_tool({"pub", "numbers", "std_msgs/UInt32", "data: 2", "--once", "--reliable"}).code, 0);
  EXPECT_TRUE(eventually([&] {
    const auto sample = numbers.take();
    return sample && sample->data() == 2;
  }));
}

class PubEveryType : public RandomTest {};

/// The node of the test announces the types that are not installed with SFT. Many commands run at the same
/// time, because each of them mostly waits.
TEST_F(PubEveryType, IsEchoedAsItWasWritten) {
  constexpr std::size_t at_once = 16;
  Node node = Node::open({.name = "everything", .transport = TransportChoice::udp}).value();
  RandomValues values{random};
  const std::span<const MessageType> types = every_type();
  for (std::size_t begin = 0; begin < types.size(); begin += at_once) {
    std::vector<DynamicSubscriber> announced;
    std::vector<std::unique_ptr<ToolProcess>> echoes;
    std::vector<std::unique_ptr<ToolProcess>> pubs;
    std::vector<std::string> messages;
    const auto part = types.subspan(begin, std::min(at_once, types.size() - begin));
    for (const MessageType& each : part) {
      const std::string name(each.support->name());
      const DynamicType type = DynamicType::parse(detail::describe(each.type())).value();
      OwnedValue value = each.make();
      values.fill(value.type(), value.get());
      tame(value.type(), value.get());
      const Encoded encoded(value.type(), value.get(), each.support->full());
      const DynamicView view(encoded.state(), type.type());
      const std::string yaml = to_yaml(view, {.elements_max = SIZE_MAX, .text_bytes_max = SIZE_MAX}).value();
      messages.push_back(to_json(view).value());
      announced.push_back(node.subscriber(each.test_name(), type, "").value());
      const std::vector<std::string> echo{"echo", each.test_name(), "--once", "--json", "--timeout", "30"};
      echoes.push_back(std::make_unique<ToolProcess>(echo));
      const std::vector<std::string> pub{"pub", each.test_name(), name, "-", "-w", "2", "--timeout", "30"};
      pubs.push_back(std::make_unique<ToolProcess>(pub));
      pubs.back()->feed(random() % 2 == 0 ? yaml : messages.back());
      pubs.back()->end_input();
    }
    for (std::size_t i = 0; i < part.size(); ++i) {
      SCOPED_TRACE(part[i].support->name());
      const Ended published = pubs[i]->end();
      EXPECT_EQ(published.code, 0) << published.err;
      const Ended echoed = echoes[i]->end();
      EXPECT_EQ(echoed.code, 0) << echoed.err;
      EXPECT_EQ(echoed.out, messages[i] + "\n");
    }
  }
}

}  // namespace
}  // namespace sft::test
