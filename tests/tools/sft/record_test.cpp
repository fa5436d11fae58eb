// The verb record. The recorded files have the topics and selections that the user names, and other
// programs can read them.
#include <sys/mount.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numeric>
#include <optional>
#include <rosgraph_msgs/msg/Clock.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <std_msgs/msg/UInt32.hpp>

#include "tests/support/isolated_host.h"
#include "tests/support/temporary_directory.h"
#include "tests/tools/sft/tool_fixture.h"
#include "tools/recording/open_recording.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::BatteryState;
using std_msgs::msg::UInt32;

/// A message in a file, as the test's own reader in Python decodes it.
using Messages = std::vector<Json>;

class RecordTest : public ToolTest {
 protected:
  std::string path(const std::string& name = "run.mcap") const { return (folder.path() / name).string(); }

  /// Starts to record, and waits until the recorder has come to each of these publishers.
  template <class... P>
  std::unique_ptr<ToolProcess> record(std::vector<std::string> arguments, const P&... publishers) {
    arguments.insert(arguments.begin(), "record");
    arguments.insert(arguments.end(), {"-o", path(), "--json"});
    auto process = std::make_unique<ToolProcess>(std::move(arguments));
    EXPECT_TRUE((publishers.wait_for_subscribers(1, hang_timeout) && ...));
    return process;
  }
  /// Ends the recording once it has so many samples.
  static Ended end(ToolProcess& process, std::size_t samples) {
    EXPECT_TRUE(process.prints("\"samples\":" + std::to_string(samples) + ",\"bytes_per_s\""));
    process.send(SIGINT);
    return process.end();
  }

  /// Reads a file by the specification of MCAP, in Python.
  Messages read(const std::string& file) const { return read_by("python3 " SFT_READ_MCAP, file); }
  Messages read_by(const std::string& program, const std::string& file) const {
    const std::string out = path("out.json"), err = path("err.txt");
    const std::string command = program + " '" + file + "' >'" + out + "' 2>'" + err + "'";
    EXPECT_EQ(std::system(command.c_str()), 0) << std::ifstream(err).rdbuf();
    Messages messages;
    std::ifstream lines(out);
    for (std::string line; std::getline(lines, line);) messages.push_back(Json::parse(line));
    return messages;
  }
  static std::vector<std::uint32_t> numbers_of(const Messages& messages,
                                               const std::string& topic = "/numbers") {
    std::vector<std::uint32_t> numbers;
    for (const Json& message : messages)
      if (message["topic"] == topic) numbers.push_back(message["value"]["data"]);
    return numbers;
  }
  /// Ten points of which each has an x and a y.
  static PointCloud2 cloud_of_two_channels() {
    PointCloud2 message = cloud();
    message.height = 1;
    message.width = 10;
    message.point_step = 8;
    message.row_step = 80;
    message.data.resize(80);
    message.fields[0].offset = 0;
    message.fields[1].offset = 4;
    for (auto& field : message.fields) {
      field.datatype = sensor_msgs::msg::PointField::FLOAT32;
      field.count = 1;
    }
    return message;
  }
  static void publish(Publisher<UInt32>& publisher, std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) EXPECT_EQ(publisher.publish({.data = i}), PublishStatus::ok);
  }

  TemporaryDirectory folder;
  Publisher<UInt32> numbers = robot.publisher<UInt32>("numbers", {.reliability = reliable}).value();
};

TEST_F(RecordTest, AnIndependentReaderFindsEachMessageFieldForField) {
  auto points = robot.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  for (const char* const compression : {"none", "lz4", "zstd"}) {
    SCOPED_TRACE(compression);
    std::filesystem::remove(path());
    auto process = record({"numbers", "/points", "--compression", compression}, numbers, points);
    publish(numbers, 0, 20);
    EXPECT_EQ(points.publish(cloud()), PublishStatus::ok);
    const Ended ended = end(*process, 21);
    EXPECT_EQ(ended.code, 0) << ended.err;
    const Messages messages = read(path());
    ASSERT_EQ(messages.size(), 21U);
    std::vector<std::uint32_t> expected(20);
    std::iota(expected.begin(), expected.end(), 0U);
    EXPECT_EQ(numbers_of(messages), expected);
    const auto found =
        std::ranges::find(messages, Json("/points"), [](const Json& one) { return one["topic"]; });
    ASSERT_NE(found, messages.end());
    EXPECT_EQ((*found)["type"], "sensor_msgs/msg/PointCloud2");
    EXPECT_EQ((*found)["value"]["header"]["frame_id"], "lidar, \"front\"");
    EXPECT_EQ((*found)["value"]["fields"][1]["name"], "y");
    EXPECT_EQ((*found)["value"]["data"].size(), 1000U);
    EXPECT_THAT((*found)["qos"].get<std::string>(), HasSubstr("reliability: 1"));
  }
}

TEST_F(RecordTest, OfAMaskedSampleAReaderSeesTheFieldsThatWereSentAndNoZero) {
  auto points = robot.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto process = record({"points{header.stamp, width, fields[].name}"}, points);
  EXPECT_EQ(points.publish(cloud()), PublishStatus::ok);
  EXPECT_EQ(end(*process, 1).code, 0);
  const Messages messages = read(path());
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_THAT(messages[0]["type"].get<std::string>(), StartsWith("sensor_msgs/msg/PointCloud2Part"));
  EXPECT_EQ(messages[0]["value"],
            Json::parse(R"({"header": {"stamp": {"sec": 7, "nanosec": 0}}, "width": 1024,
                                                  "fields": [{"name": "x"}, {"name": "y"}]})"));
}

TEST_F(RecordTest, FoxglovesReadersDecodeWholeMessagesPartsAndMaskedSamplesFieldForField) {
  if (!std::filesystem::exists(SFT_FOXGLOVE "/.of-lock"))
    GTEST_SKIP() << "skipped: needs npm, from which ./run build installs Foxglove's readers";
  constexpr std::array<const char*, 5> selected{
      "whole", "part{data{y}[::2]}", "some{header.stamp, width, fields[].name}",
      "length{header.frame_id, fields.size, is_dense}", "elements{fields[].count, data}"};
  std::vector<std::string> arguments(selected.begin(), selected.end());
  arguments.insert(arguments.end(), {"battery{voltage, cell_voltage, present, location}", "--compression"});
  std::vector<Publisher<PointCloud2>> clouds;
  for (const std::string topic : selected)
    clouds.push_back(
        robot.publisher<PointCloud2>(topic.substr(0, topic.find('{')), {.reliability = reliable}).value());
  auto battery = robot.publisher<BatteryState>("battery", {.reliability = reliable}).value();
  for (const char* const compression : {"none", "lz4", "zstd"}) {
    SCOPED_TRACE(compression);
    std::filesystem::remove(path());
    arguments.emplace_back(compression);
    auto process = record(arguments, clouds[0], clouds[1], clouds[2], clouds[3], clouds[4], battery);
    arguments.pop_back();
    for (auto& publisher : clouds) EXPECT_EQ(publisher.publish(cloud_of_two_channels()), PublishStatus::ok);
    EXPECT_EQ(battery.publish({.voltage = 12.5F, .cell_voltage = {4, 4.25F}, .location = "left"}),
              PublishStatus::ok);
    EXPECT_EQ(end(*process, 6).code, 0);
    const Messages messages = read(path());
    EXPECT_EQ(messages.size(), 6U);
    EXPECT_EQ(read_by("NODE_PATH=" SFT_FOXGLOVE " node " SFT_FOXGLOVE_READ_MCAP, path()), messages);
  }
}

TEST_F(RecordTest, APartIsAValidMessageOfTheTopicsType) {
  auto points = robot.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto process = record({"points{data{y}[::2]}"}, points);
  const PointCloud2 message = cloud_of_two_channels();
  EXPECT_EQ(points.publish(message), PublishStatus::ok);
  EXPECT_EQ(end(*process, 1).code, 0);
  const Messages messages = read(path());
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0]["type"], "sensor_msgs/msg/PointCloud2");
  EXPECT_EQ(messages[0]["value"]["header"]["frame_id"], message.header.frame_id);
  EXPECT_EQ(messages[0]["value"]["width"], 5);
  EXPECT_EQ(messages[0]["value"]["point_step"], 4);
  EXPECT_EQ(messages[0]["value"]["fields"].size(), 1U);
  EXPECT_EQ(messages[0]["value"]["data"].size(), 20U);
}

TEST_F(RecordTest, ConditionsLetSomeSamplesPass) {
  auto process = record({"numbers@every 2"}, numbers);
  publish(numbers, 0, 10);
  EXPECT_EQ(end(*process, 5).code, 0);
  EXPECT_EQ(numbers_of(read(path())), (std::vector<std::uint32_t>{0, 2, 4, 6, 8}));
}

TEST_F(RecordTest, InSharedMemoryTheFileIsTheSame) {
  Node local = open("local", TransportChoice::shm);
  auto points = local.publisher<PointCloud2>("clouds", {.reliability = reliable}).value();
  ASSERT_TRUE(eventually([&] { return local.status().shm_ready; }));
  auto process = record({"clouds{width, height}"}, points);
  EXPECT_EQ(points.publish(cloud()), PublishStatus::ok);
  EXPECT_EQ(end(*process, 1).code, 0);
  const Messages messages = read(path());
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0]["value"], Json::parse(R"({"height": 1, "width": 1024})"));
}

TEST_F(RecordTest, RetainedSamplesOfEachPublisherBeginEachFile) {
  const PublisherOptions kept{.reliability = reliable, .durability = transient_local, .history_depth = 2};
  Node other = open("other");
  auto map = robot.publisher<UInt32>("map", kept).value();
  auto second_map = other.publisher<UInt32>("map", kept).value();
  auto plain_map = open("plain").publisher<UInt32>("map").value();  // another offer on the same topic
  publish(map, 0, 3);
  publish(second_map, 10, 13);
  auto process = record({"map", "numbers", "--split-time", "0.2"}, numbers);
  ASSERT_TRUE(process->prints("\"samples\":4,\"bytes_per_s\""));
  publish(numbers, 0, 1);
  ASSERT_TRUE(process->prints("\"samples\":5,\"bytes_per_s\""));
  publish(numbers, 1, 2);
  EXPECT_EQ(end(*process, 6).code, 0);
  std::size_t files = 0;
  for (; std::filesystem::exists(path("run_" + std::to_string(files) + ".mcap")); ++files) {
    const Messages messages = read(path("run_" + std::to_string(files) + ".mcap"));
    ASSERT_GE(messages.size(), 4U);
    std::vector<std::uint32_t> retained = numbers_of({messages.begin(), messages.begin() + 4}, "/map");
    std::ranges::sort(retained);
    EXPECT_EQ(retained, (std::vector<std::uint32_t>{1, 2, 11, 12})) << "file " << files;
  }
  EXPECT_GE(files, 2U);
}

TEST_F(RecordTest, FilesAreSplitBySizeAndNoSampleIsLostBetweenThem) {
  auto points = robot.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto process = record({"points", "--split-mb", "0.5"}, points);
  PointCloud2 message = cloud();
  message.data.resize(300'000);
  for (std::uint32_t i = 0; i < 6; ++i) {
    message.width = i;
    EXPECT_EQ(points.publish(message), PublishStatus::ok);
  }
  EXPECT_EQ(end(*process, 6).code, 0);
  std::vector<std::uint32_t> widths;
  for (std::size_t i = 0; i < 3; ++i) {
    for (const Json& one : read(path("run_" + std::to_string(i) + ".mcap")))
      widths.push_back(one["value"]["width"]);
  }
  EXPECT_EQ(widths, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
}

TEST_F(RecordTest, WithSimulatedTimeNothingIsStampedBeforeTheFirstClock) {
  auto clock = robot.publisher<rosgraph_msgs::msg::Clock>("clock").value();
  const Ticker early(5ms, [this](std::uint32_t i) { numbers.publish({.data = i}); });
  ToolProcess process({"record", "numbers", "--use-sim-time", "-o", path(), "--for", "3"});
  ASSERT_TRUE(clock.wait_for_subscribers(1, hang_timeout));
  const Ticker ticking(10ms, [&clock](std::uint32_t i) {
    rosgraph_msgs::msg::Clock message;
    message.clock.sec = 1000 + static_cast<std::int32_t>(i / 100);
    clock.publish(message);
  });
  EXPECT_EQ(process.end().code, 0);
  const Messages messages = read(path());
  EXPECT_FALSE(messages.empty());
  for (const Json& message : messages) {
    EXPECT_GE(message["log_time"], 1000 * std::uint64_t{1'000'000'000});
    EXPECT_LT(message["log_time"], 2000 * std::uint64_t{1'000'000'000});
  }
  EXPECT_EQ(recording::open_recording(path()).value()->overview().metadata.at("sft_recording").at("clock"),
            "/clock");
}

TEST_F(RecordTest, AKilledRecorderLeavesAFileThatOpens) {
  auto process = record({"numbers"}, numbers);
  publish(numbers, 0, 50);
  ASSERT_TRUE(process->prints("\"samples\":50,"));
  const auto reads = [&] {
    const auto bag = recording::open_recording(path());
    std::size_t messages = 0;
    while (bag && (*bag)->next()) ++messages;
    return messages;
  };
  ASSERT_TRUE(eventually([&] { return reads() == 50; })) << "chunks are written each second";
  process->send(SIGKILL);
  EXPECT_EQ(process->end().code, -SIGKILL);
  EXPECT_EQ(reads(), 50U);
  EXPECT_EQ(run_tool({"bag", "info", path()}).code, 0);
  EXPECT_EQ(run_tool({"bag", "check", path()}).code, 2);
}

TEST_F(RecordTest, AFullDiskIsAnErrorAndTheFileIsWhole) {
  const std::string disk = path("disk");
  std::filesystem::create_directory(disk);
  if (!isolation_refusal().empty() || mount("none", disk.c_str(), "tmpfs", 0, "size=1m") != 0)
    GTEST_SKIP() << "a small disk cannot be mounted";
  auto points = robot.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  PointCloud2 message = cloud();
  message.data.resize(300'000);
  ToolProcess process({"record", "points", "-o", disk + "/run.mcap"});
  ASSERT_TRUE(points.wait_for_subscribers(1, hang_timeout));
  const Publishing publishing(points, message, 20ms);
  const Ended ended = process.end();
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.err, HasSubstr("/run.mcap' cannot be written: No space left on device"));
  EXPECT_THAT(ended.out, HasSubstr("3 samples written")) << "what the disk refused is not counted";
  EXPECT_THAT(ended.out, ::testing::ContainsRegex("lost: .* [1-9][0-9]* by the disk"));
  EXPECT_EQ(read(disk + "/run.mcap").size(), 3U);
  umount(disk.c_str());
}

TEST_F(RecordTest, AWindowIsWrittenWhenAConditionOpens) {
  auto battery = robot.publisher<BatteryState>("battery", {.reliability = reliable}).value();
  auto process = record({"numbers", "battery", "--last", "100", "--on", "voltage < 11"}, numbers);
  ASSERT_TRUE(battery.wait_for_subscribers(2, hang_timeout)) << "one of them waits for the condition";
  publish(numbers, 0, 10);
  EXPECT_EQ(battery.publish({.voltage = 12}), PublishStatus::ok);
  ASSERT_TRUE(process->prints("\"samples\":11,"));
  EXPECT_FALSE(std::filesystem::exists(path("run_0.mcap")));
  EXPECT_EQ(battery.publish({.voltage = 10}), PublishStatus::ok);
  ASSERT_TRUE(eventually([&] { return std::filesystem::exists(path("run_0.mcap")); }));
  EXPECT_EQ(end(*process, 12).code, 0);
  const Messages messages = read(path("run_0.mcap"));
  EXPECT_EQ(numbers_of(messages).size(), 10U);
  EXPECT_EQ(messages.size(), 12U) << "the sample that fulfils the condition is there, too";
}

TEST_F(RecordTest, ATopicThatCannotBeRecordedSpoilsNoOther) {
  auto process = record({"numbers", "nobody", "--for", "7"}, numbers);
  publish(numbers, 0, 5);
  const Ended ended = process->end();
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.err, HasSubstr("topic 'nobody' has no publisher yet"));
  EXPECT_EQ(numbers_of(read(path())).size(), 5U);
}

TEST_F(RecordTest, APublisherThatComesBackWithAWeakerOfferIsHeard) {
  auto process = record({"numbers"}, numbers);
  publish(numbers, 0, 5);
  ASSERT_TRUE(process->prints("\"samples\":5,"));
  auto weaker = open("second").publisher<UInt32>("numbers").value();
  ASSERT_TRUE(weaker.wait_for_subscribers(1, hang_timeout));
  publish(weaker, 100, 101);
  publish(numbers, 5, 6);
  EXPECT_EQ(end(*process, 7).code, 0);
  std::vector<std::uint32_t> found = numbers_of(read(path()));
  std::ranges::sort(found);
  EXPECT_EQ(found, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 100}));
}

TEST_F(RecordTest, RetainedSamplesOfPublishersThatBeginAtOnceComeOnce) {
  const PublisherOptions kept{.reliability = reliable, .durability = transient_local, .history_depth = 2};
  auto weak = robot.publisher<UInt32>("mixed").value();
  auto process = record({"mixed"}, weak);
  publish(weak, 0, 1);
  ASSERT_TRUE(process->prints("\"samples\":1,"));
  std::vector<Publisher<UInt32>> late;
  std::vector<std::uint32_t> expected{0};
  for (std::uint32_t i = 1; i <= 10; ++i) {
    late.push_back(robot.publisher<UInt32>("mixed", kept).value());
    publish(late.back(), 10 * i, 10 * i + 1);
    ASSERT_TRUE(late.back().wait_for_subscribers(1, hang_timeout));
    // It comes by the subscriber that is there, mostly before the recorder has seen its publisher.
    publish(late.back(), 10 * i + 1, 10 * i + 2);
    expected.insert(expected.end(), {10 * i, 10 * i + 1});
  }
  EXPECT_EQ(end(*process, expected.size()).code, 0);
  std::vector<std::uint32_t> found = numbers_of(read(path()), "/mixed");
  std::ranges::sort(found);
  EXPECT_EQ(found, expected);
}

TEST_F(RecordTest, WhatWasLostOfADepartedPublisherIsStillCounted) {
  auto brief = std::make_optional(robot.publisher<UInt32>("brief").value());
  auto process = record({"brief", "numbers"}, *brief, numbers);
  publish(*brief, 0, 5);
  ASSERT_TRUE(process->prints("\"samples\":5,"));
  process->send(SIGSTOP);
  for (std::uint32_t i = 5; i < 20'000; ++i) (void)brief->publish({.data = i});  // its queues overflow
  process->send(SIGCONT);
  publish(*brief, 20'000, 20'001);
  publish(numbers, 0, 1);
  ASSERT_TRUE(process->prints("\"numbers\":{\"samples\":1"));
  brief.reset();
  ASSERT_TRUE(eventually([&] { return robot.domain().publishers.size() == 1; }));
  publish(numbers, 1, 2);
  ASSERT_TRUE(process->prints("\"numbers\":{\"samples\":2"));
  process->send(SIGINT);
  const Ended ended = process->end();
  const Json summary = Json::parse(ended.out.substr(ended.out.rfind("{\"files\"")));
  EXPECT_GT(summary["lost"], 0);
}

TEST_F(RecordTest, TopicsThatComeLaterAreRecordedFromTheirFirstSample) {
  ToolProcess process({"record", "--all", "-o", path(), "--json", "--compression", "lz4"});
  std::vector<Publisher<UInt32>> late;
  for (int i = 0; i < 10; ++i)
    late.push_back(robot.publisher<UInt32>("late" + std::to_string(i), {.reliability = reliable}).value());
  for (Publisher<UInt32>& publisher : late) {
    ASSERT_TRUE(publisher.wait_for_subscribers(1, hang_timeout));
    publish(publisher, 0, 100);
  }
  EXPECT_EQ(end(process, 1000).code, 0);
  const Messages messages = read(path());
  std::vector<std::uint32_t> expected(100);
  std::iota(expected.begin(), expected.end(), 0U);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(numbers_of(messages, "/late" + std::to_string(i)), expected) << i;
}

TEST_F(RecordTest, WhoeverHeardAPublisherLiveHearsItPlayed) {
  const PublisherOptions kept{.reliability = reliable, .durability = transient_local, .history_depth = 1};
  auto latched = std::make_optional(robot.publisher<UInt32>("mixed", kept).value());
  auto plain = std::make_optional(open("plain").publisher<UInt32>("mixed").value());
  publish(*latched, 7, 8);
  auto process = record({"mixed"}, *plain, *latched);
  ASSERT_TRUE(process->prints("\"samples\":1,\"bytes_per_s\""));
  publish(*plain, 8, 9);
  EXPECT_EQ(end(*process, 2).code, 0);
  latched.reset();
  plain.reset();
  ToolProcess player({"play", path(), "--loop", "--rate", "0.01"});
  auto strong =
      robot.subscriber<UInt32>("mixed", {.reliability = reliable, .durability = transient_local}).value();
  auto weak = robot.subscriber<UInt32>("mixed").value();
  const auto both_offers = [&] {
    const SubscriberStatus status = weak.status();
    return std::ranges::count_if(status.writers, &SubscriberStatus::Writer::connected) == 2;
  };
  EXPECT_TRUE(eventually(both_offers)) << "the weak reader has both publishers";
  ASSERT_TRUE(strong.wait(hang_timeout));
  const auto retained = strong.take();
  EXPECT_EQ(retained->data(), 7U) << "and the strong one hears what is retained";
  player.send(SIGINT);
  EXPECT_EQ(player.end().code, 0);
}

TEST_F(RecordTest, MistakesAreNamedBeforeAFileIsMade) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> mistakes{
      {{"record"}, "Name topics, or --all."},
      {{"record", "points{width"}, "a brace is not closed"},
      {{"record", "points{}"}, "there is nothing in the braces"},
      {{"record", "a", "a{data}"}, "topic 'a' is named twice"},
      {{"record", "numbers", "--last", "3"}, "--last and --on belong together."}};
  for (const auto& [arguments, text] : mistakes) {
    const Ended ended = run_tool(arguments);
    EXPECT_EQ(ended.code, 2) << text;
    EXPECT_THAT(ended.err, HasSubstr(text));
  }
  const Ended wrong_field = run_tool({"record", "numbers{dat}", "-o", path()});
  EXPECT_EQ(wrong_field.code, 2);
  EXPECT_THAT(wrong_field.err, HasSubstr("topic 'numbers': column 1"));
  EXPECT_FALSE(std::filesystem::exists(path()));
  std::ofstream(path()) << "mine";
  EXPECT_THAT(run_tool({"record", "numbers", "-o", path()}).err,
              HasSubstr("is there already; name another file."));
  std::ofstream(path("part_0.mcap")) << "mine";
  const Ended split = run_tool({"record", "numbers", "--split-mb", "1", "-o", path("part.mcap")});
  EXPECT_EQ(split.code, 2);
  EXPECT_THAT(split.err, HasSubstr("part_0.mcap' is there already"));
  const Ended nowhere =
      run_tool({"record", "numbers", "--last", "3", "--on", "data > 1", "-o", path("none/run.mcap")});
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("none/run_0.mcap' cannot be made: No such file or directory"));
}

}  // namespace
}  // namespace sft::test
