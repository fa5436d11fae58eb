// The verbs play and bag, with files of this test and with recorded bags.
#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numeric>
#include <std_msgs/msg/UInt32.hpp>

#include "sft/json.h"
#include "tests/support/temporary_directory.h"
#include "tests/tools/sft/tool_fixture.h"
#include "tools/recording/mcap_writer.h"
#include "tools/recording/qos_profile.h"

namespace sft::test {
namespace {

using std_msgs::msg::UInt32;
using Clock = std::chrono::steady_clock;

class PlayTest : public ToolTest {
 protected:
  static constexpr std::uint64_t ms = 1'000'000;
  static constexpr std::uint64_t begin_ns = 1'700'000'000'000 * ms;

  std::string path(const std::string& name = "run.mcap") const { return (folder.path() / name).string(); }

  /// A number at a time, in ms from the begin.
  struct Timed {
    std::uint64_t at_ms;
    std::uint32_t number;
    std::uint16_t channel = 1;
  };
  /// Writes a file with the topics `numbers`, best effort, `map`, of which two samples are retained, and
  /// `steps`, reliable.
  std::string write(const std::vector<Timed>& messages, const std::string& name = "run.mcap") const {
    auto writer = recording::McapWriter::create(path(name), {}).value();
    writer.declare({.id = 1, .name = "std_msgs/msg/UInt32", .encoding = "ros2msg", .data = "uint32 data\n"});
    const Qos kept{.reliability = reliable, .durability = transient_local, .history_depth = 2};
    writer.declare({.id = 1, .schema = 1, .topic = "/numbers"});
    writer.declare({.id = 2,
                    .schema = 1,
                    .topic = "/map",
                    .metadata = {{"offered_qos_profiles", recording::to_profile(kept)}}});
    writer.declare(
        {.id = 3,
         .schema = 1,
         .topic = "/steps",
         .metadata = {{"offered_qos_profiles", recording::to_profile(Qos{.reliability = reliable})}}});
    for (const Timed& one : messages) {
      std::array<std::byte, 8> cdr{std::byte{0}, std::byte{1}};
      std::memcpy(cdr.data() + 4, &one.number, 4);
      const std::uint64_t time = begin_ns + one.at_ms * ms;
      EXPECT_TRUE(writer.write(
          {.channel = one.channel, .sequence = one.number, .log_ns = time, .publish_ns = time, .data = cdr}));
    }
    EXPECT_TRUE(writer.close());
    return path(name);
  }

  /// The number and the times of a retained sample, in ms from the begin.
  struct Retained {
    std::uint32_t sequence = 0;
    std::uint64_t log_ms = 0, publish_ms = 0;
  };
  /// Writes a file with the topic `map` only, which has two retained samples with the values 1 and 2.
  std::string write_map(const std::string& name, const std::array<Retained, 2>& samples) const {
    auto writer = recording::McapWriter::create(path(name), {}).value();
    writer.declare({.id = 1, .name = "std_msgs/msg/UInt32", .encoding = "ros2msg", .data = "uint32 data\n"});
    const Qos kept{.reliability = reliable, .durability = transient_local, .history_depth = 2};
    writer.declare({.id = 1,
                    .schema = 1,
                    .topic = "/map",
                    .metadata = {{"offered_qos_profiles", recording::to_profile(kept)}}});
    for (std::uint32_t i = 0; i < samples.size(); ++i) {
      const std::uint32_t value = i + 1;
      std::array<std::byte, 8> cdr{std::byte{0}, std::byte{1}};
      std::memcpy(cdr.data() + 4, &value, 4);
      EXPECT_TRUE(writer.write({.channel = 1,
                                .sequence = samples[i].sequence,
                                .log_ns = begin_ns + samples[i].log_ms * ms,
                                .publish_ns = begin_ns + samples[i].publish_ms * ms,
                                .data = cdr}));
    }
    EXPECT_TRUE(writer.close());
    return path(name);
  }

  /// The numbers that came on a topic, and when.
  struct Heard {
    std::vector<std::uint32_t> numbers;
    std::vector<Clock::time_point> times;
  };
  static void hear(Subscriber<UInt32>& subscriber, std::size_t count, Heard& heard) {
    while (heard.numbers.size() < count && subscriber.wait(hang_timeout)) {
      while (const auto sample = subscriber.take()) {
        heard.numbers.push_back(sample->data());
        heard.times.push_back(Clock::now());
      }
    }
  }
  Subscriber<UInt32> listen(const std::string& topic, const SubscriberOptions& options = {}) {
    return robot.subscriber<UInt32>(topic, options).value();
  }

  TemporaryDirectory folder;
};

TEST_F(PlayTest, SamplesComeInOrderAndInTheirTime) {
  const std::string file = write({{0, 1}, {100, 2}, {150, 3}, {400, 4}});
  auto numbers = listen("numbers", {.depth = 100});
  Heard heard;
  ToolProcess process({"play", file, "-w"});
  hear(numbers, 4, heard);
  EXPECT_EQ(process.end().code, 0);
  EXPECT_EQ(heard.numbers, (std::vector<std::uint32_t>{1, 2, 3, 4}));
  EXPECT_GE(heard.times[3] - heard.times[0], 350ms);
}

TEST_F(PlayTest, RateStartTopicsAndNewNames) {
  const std::string file = write({{0, 1}, {1000, 2}, {1000, 9, 2}, {3000, 3}, {60'000, 4}});
  auto numbers = listen("replay/numbers", {.depth = 100});
  Heard heard;
  const auto begin = Clock::now();
  ToolProcess process({"play", file, "-w", "--rate", "100", "--start", "0.5", "--for", "10", "--topics",
                       "numbers", "--remap", "/numbers:=replay/numbers", "--json"});
  hear(numbers, 2, heard);
  const Ended ended = process.end();
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(heard.numbers, (std::vector<std::uint32_t>{2, 3}));
  EXPECT_EQ(Json::parse(ended.out)["published"], 2);
  EXPECT_LT(Clock::now() - begin, 50s) << "60 s of the recording were not played at their speed";
}

TEST_F(PlayTest, LatchedTopicsAreOfferedAsTheyWereAndBeginWithWhatWasRetained) {
  const std::string file = write({{0, 1, 2}, {10, 2, 2}, {20, 3, 2}, {5000, 50}, {5010, 4, 2}, {60'000, 51}});
  auto map = listen("map", {.reliability = reliable, .durability = transient_local});
  ToolProcess process({"play", file, "--start", "5"});
  Heard heard;
  hear(map, 3, heard);
  EXPECT_EQ(heard.numbers, (std::vector<std::uint32_t>{2, 3, 4}));
  auto late = listen("map", {.reliability = reliable, .durability = transient_local});
  Heard late_heard;
  hear(late, 2, late_heard);
  EXPECT_EQ(late_heard.numbers, (std::vector<std::uint32_t>{3, 4})) << "a late reader gets what is retained";
  process.send(SIGINT);
  EXPECT_EQ(process.end().code, 0);
}

TEST_F(PlayTest, SeveralFilesAreOneRecordingAndRetainedSamplesComeOnce) {
  write({{0, 1, 2}, {10, 10}, {30, 12}}, "run_0.mcap");
  // The second file begins with what was retained: the same sample, with its number and time of publishing.
  write_map("run_1.mcap", {{{.sequence = 1, .log_ms = 20, .publish_ms = 0},
                            {.sequence = 2, .log_ms = 21, .publish_ms = 1}}});
  auto map = listen("map", {.reliability = reliable, .durability = transient_local});
  auto numbers = listen("numbers", {.depth = 100});
  const Ended ended = run_tool({"play", folder.path().string(), "-w", "--json"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(Json::parse(ended.out)["topics"], Json::parse(R"({"map": 2, "numbers": 2})"));
  Heard heard;
  hear(map, 2, heard);
  EXPECT_EQ(heard.numbers, (std::vector<std::uint32_t>{1, 2}));
}

TEST_F(PlayTest, ALoopBeginsAnewAndTheClockGoesBackOnce) {
  const std::string file = write({{0, 1}, {50, 2}, {100, 3}});
  auto numbers = listen("numbers", {.depth = 1000});
  Node follower =
      Node::open({.name = "follower", .use_sim_time = true, .transport = TransportChoice::udp}).value();
  ToolProcess process({"play", file, "-w", "--loop", "--clock", "100"});
  Heard heard;
  hear(numbers, 7, heard);
  EXPECT_EQ(std::vector(heard.numbers.begin(), heard.numbers.begin() + 7),
            (std::vector<std::uint32_t>{1, 2, 3, 1, 2, 3, 1}));
  EXPECT_TRUE(eventually([&] {
    const auto now = static_cast<std::uint64_t>(follower.now().time_since_epoch().count());
    return now >= begin_ns && now <= begin_ns + 100 * ms;
  }));
  process.send(SIGINT);
  EXPECT_EQ(process.end().code, 0);
}

TEST_F(PlayTest, ALoopOfASingleMomentIsNotPublishedWithoutAPause) {
  const std::string file = write({{0, 1}});
  auto numbers = listen("numbers", {.depth = 1000});
  ToolProcess process({"play", file, "-w", "--loop"});
  Heard heard;
  hear(numbers, 3, heard);
  EXPECT_GE(heard.times[2] - heard.times[0], 300ms);
  process.send(SIGINT);
  EXPECT_EQ(process.end().code, 0);
}

TEST_F(PlayTest, ATerminalIsReadByKeysAndLeftAsItWas) {
  const std::string file = write({{0, 1}, {20, 2}});
  auto numbers = listen("numbers", {.depth = 1000});
  ToolProcess process({"play", file, "-w", "--loop"}, ToolProcess::On::terminal);
  Heard heard;
  hear(numbers, 2, heard);
  EXPECT_FALSE(process.echoes());
  process.send(SIGTERM);
  EXPECT_EQ(process.end().code, 0);
  EXPECT_TRUE(process.echoes());
}

TEST_F(PlayTest, TheSpaceBarPausesAndGoesOn) {
  const std::string file = write({{0, 1}, {1000, 2}});
  auto numbers = listen("numbers", {.depth = 100});
  ToolProcess process({"play", file, "-w"}, ToolProcess::On::terminal);
  Heard heard;
  hear(numbers, 1, heard);
  process.press(" ");
  EXPECT_FALSE(numbers.wait(2s)) << "the second number comes only after the pause";
  process.press(" ");
  hear(numbers, 2, heard);
  EXPECT_EQ(heard.numbers, (std::vector<std::uint32_t>{1, 2}));
  const Ended ended = process.end();
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.err, HasSubstr("Paused; the space bar goes on."));
}

TEST_F(PlayTest, AReliableSubscriberThatDoesNotKeepUpSlowsAllTopics) {
  constexpr std::uint32_t count = 10'000;  // more than UDP buffers (udp::ResendLimits: 4096)
  std::vector<Timed> messages;
  for (std::uint32_t i = 1; i <= count; ++i) messages.push_back({i / 10, i, 3});
  messages.push_back({count / 10, 99});
  const std::string file = write(messages);
  auto steps = listen("steps", {.reliability = reliable, .depth = 4});
  auto numbers = listen("numbers");
  std::vector<std::uint32_t> taken;
  bool number_came = false;
  ToolProcess process({"play", file, "-w"});
  // The recording has a sample each 100 us.
  for (Pace pace(500us); !number_came && steps.wait(hang_timeout); pace.await_turn()) {
    number_came = !!numbers.take();
    if (const auto sample = steps.take()) taken.push_back(sample->data());
  }
  std::vector<std::uint32_t> all(taken.size());
  std::iota(all.begin(), all.end(), 1U);
  EXPECT_EQ(taken, all) << "nothing was lost";
  EXPECT_TRUE(number_came);
  EXPECT_GT(taken.size(), count / 2) << "the other topic has to slow down, too";
  const Ended ended = process.end();
  EXPECT_THAT(ended.err, HasSubstr("It cannot keep up: all topics slow down."));
  EXPECT_THAT(ended.err, HasSubstr("It was late by"));
}

TEST_F(PlayTest, ASubscriberOfAnotherTypeIsNamed) {
  const std::string file = write({{0, 1}, {200, 2}});
  auto points = robot.subscriber<PointCloud2>("numbers").value();
  const Ended ended = run_tool({"play", file});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.err, HasSubstr("Node 'lidar' was sent nothing of 'numbers': "));
}

TEST_F(PlayTest, WhoDoesNotComeIsNamed) {
  const std::string file = write({{0, 1}});
  const Ended ended =
      run_tool({"play", file, "--wait-for-subscribers", "2", "--timeout", "0.2", "--wait", "0"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.err,
              HasSubstr("Nothing was played: 2 subscribers of 'numbers' did not come within 0.2 s"));
}

TEST_F(PlayTest, WhatCannotBePlayedIsNamed) {
  std::ofstream(path("text.mcap")) << "hello";
  EXPECT_THAT(run_tool({"play", path("text.mcap")}).err, HasSubstr("is no MCAP file"));
  EXPECT_EQ(run_tool({"play", path("missing.mcap")}).code, 1);
  const std::string file = write({{0, 1}});
  EXPECT_THAT(run_tool({"play", file, "--remap", "a"}).err, HasSubstr("'a' is no rule: write OLD:=NEW"));
}

TEST_F(PlayTest, BagsOfRosbag2ArePlayedWithTheTypesThatAreInstalled) {
  const std::string bag = SFT_TEST_DATA_DIR "/rosbag2/neato_drive_square";
  if (!std::filesystem::exists(bag)) GTEST_SKIP() << "there is no " << bag;
  const Ended ended = run_tool({"play", bag, "--rate", "100", "--wait", "0", "--json"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.err, HasSubstr("topic 'bump' is left out"));
  const Json json = Json::parse(ended.out);
  EXPECT_EQ(json["topics"]["scan"], 185);
  EXPECT_EQ(json["topics"]["tf_static"], 2);
  EXPECT_EQ(json["published"], 2091 - 2 * 194);
}

TEST_F(PlayTest, DamageThatIsFoundWhilePlayingIsNamedAndAnError) {
  const std::string file = write({{0, 1}, {10, 2}});
  std::string content;
  {
    std::ifstream whole(file, std::ios::binary);
    content.assign(std::istreambuf_iterator(whole), {});
  }
  content[content.find(std::string("\0\1\0\0\1\0\0\0", 8)) + 4] = 7;
  std::ofstream(file, std::ios::binary) << content;
  write({{0, 1}, {10, 2}}, "whole.mcap");
  const Ended ended = run_tool({"play", file, path("whole.mcap"), "--wait", "0"});
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.err, HasSubstr("run.mcap: Chunk at offset"));
  EXPECT_THAT(ended.err, HasSubstr("its checksum is wrong; it is left out"));
}

TEST_F(PlayTest, RetainedSamplesOfOneTimeAndNumberButDifferentContentsAreAllPlayed) {
  const std::string file = write_map("run.mcap", {});
  EXPECT_EQ(Json::parse(run_tool({"play", file, "--wait", "0", "--json"}).out)["published"], 2);
}

class BagTest : public PlayTest {};

TEST_F(BagTest, InfoShowsTopicsTypesCountsAndQos) {
  const std::string file = write({{0, 1}, {1000, 2}, {1000, 3, 2}});
  const Ended ended = run_tool({"bag", "info", file});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("3 messages, 1.000 s from 2023-11-14 22:13:20.000 UTC on"));
  EXPECT_THAT(ended.out, HasSubstr("std_msgs/msg/UInt32"));
  EXPECT_THAT(ended.out, HasSubstr("reliable, keeps 2"));
  const Json json = Json::parse(run_tool({"bag", "info", file, "--json"}).out);
  EXPECT_EQ(json["messages"], 3);
  EXPECT_EQ(json["channels"][1]["topic"], "/numbers");
}

TEST_F(BagTest, ANewFileIsMadeFromOneRecordingOnly) {
  write({{0, 1}}, "run_0.mcap");
  write({{0, 1}}, "run_1.mcap");
  for (const std::vector<std::string>& given :
       {std::vector<std::string>{"repair", folder.path().string(), "-o", path("new.mcap")},
        std::vector<std::string>{"estimate", folder.path().string(), "--html", path("page.html")}}) {
    std::vector<std::string> arguments{"bag"};
    arguments.insert(arguments.end(), given.begin(), given.end());
    const Ended ended = run_tool(arguments);
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.err, HasSubstr("A new file is made from one recording only"));
  }
  EXPECT_FALSE(std::filesystem::exists(path("new.mcap")));
}

TEST_F(BagTest, APageThatCannotBeWrittenIsNamedWithTheReason) {
  const Ended ended = run_tool({"bag", "estimate", write({{0, 1}}), "--html", "/dev/full"});
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.err, HasSubstr("'/dev/full' cannot be written: No space left on device"));
}

TEST_F(BagTest, CheckFindsAFlippedByte) {
  const std::string file = write({{0, 1}, {1000, 2}});
  EXPECT_EQ(run_tool({"bag", "check", file}).code, 0);
  std::string content;
  {
    std::ifstream whole(file, std::ios::binary);
    content.assign(std::istreambuf_iterator(whole), {});
  }
  content[200] = static_cast<char>(content[200] ^ 1);
  std::ofstream(file, std::ios::binary) << content;
  const Ended ended = run_tool({"bag", "check", file});
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.out, HasSubstr("Chunk at offset"));
  EXPECT_THAT(ended.out, HasSubstr("its checksum is wrong; it is left out"));
}

TEST_F(BagTest, RepairKeepsAllButTheDamagedChunkAndNamesIt) {
  const std::string file = path("twenty.mcap");
  {
    auto writer = recording::McapWriter::create(file, {.chunk_bytes = 1}).value();
    writer.declare({.id = 1, .name = "std_msgs/msg/UInt32", .encoding = "ros2msg", .data = "uint32 data\n"});
    writer.declare({.id = 1, .schema = 1, .topic = "/numbers", .metadata = {{"offered_qos_profiles", ""}}});
    for (std::uint32_t i = 0; i < 20; ++i) {
      std::array<std::byte, 8> cdr{std::byte{0}, std::byte{1}};
      std::memcpy(cdr.data() + 4, &i, 4);
      EXPECT_TRUE(writer.write({.channel = 1, .sequence = i, .log_ns = begin_ns + i, .data = cdr}));
    }
    std::string attachment(8 + 8 + 4 + 1 + 4 + 8 + 2 + 4, '\0');
    attachment[16] = 1;
    attachment[20] = 'a';
    attachment[25] = 2;
    EXPECT_TRUE(writer.write_attachment(recording::bytes_of(attachment)));
    EXPECT_TRUE(writer.write_metadata("robot", {{"serial", "7"}}));
    EXPECT_TRUE(writer.close());
  }
  std::string content;
  {
    std::ifstream whole(file, std::ios::binary);
    content.assign(std::istreambuf_iterator(whole), {});
  }
  std::string number_five("\0\1\0\0\5\0\0\0", 8);
  content[content.find(number_five) + 4] = 6;
  std::ofstream(file, std::ios::binary) << content;
  const Ended ended = run_tool({"bag", "repair", file, "-o", path("good.mcap")});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("its checksum is wrong; it is left out"));
  EXPECT_THAT(ended.out, HasSubstr("19 messages written and read again"));
  EXPECT_EQ(run_tool({"bag", "check", path("good.mcap")}).code, 0);
  const Json json = Json::parse(run_tool({"bag", "info", path("good.mcap"), "--json"}).out);
  EXPECT_EQ(json["messages"], 19);
  EXPECT_EQ(json["metadata"]["robot"]["serial"], "7");
  EXPECT_EQ(json["attachments"]["a"], 2);
  const std::string python = "python3 " SFT_READ_MCAP " '" + path("good.mcap") + "' >/dev/null";
  EXPECT_EQ(std::system(python.c_str()), 0) << "an independent reader reads all of it";
}

TEST_F(BagTest, EstimateSaysWhyNothingCanBeEstimated) {
  const auto make = [&](const char* name, const char* definition) {
    auto writer = recording::McapWriter::create(path(name), {}).value();
    writer.declare({.id = 1, .name = "my_msgs/msg/Odd", .encoding = "ros2msg", .data = definition});
    writer.declare({.id = 1, .schema = 1, .topic = "/odd"});
    const std::array<std::byte, 8> cdr{std::byte{0}, std::byte{1}};
    const recording::Message message{.channel = 1, .log_ns = begin_ns, .publish_ns = begin_ns, .data = cdr};
    EXPECT_TRUE(*definition == '\0' || writer.write(message));
    EXPECT_TRUE(writer.close());
    return path(name);
  };
  const Ended unknown = run_tool({"bag", "estimate", make("odd.mcap", "my_msgs/Unknown part\n")});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_THAT(unknown.out, StartsWith("nothing to estimate, since no message could be read: topic 'odd'"));
  const Ended empty = run_tool({"bag", "estimate", make("empty.mcap", "")});
  EXPECT_EQ(empty.code, 1);
  EXPECT_EQ(empty.out, "nothing to estimate: the recording has no messages\n");
}

TEST_F(BagTest, EstimateSaysWhatSelectionsSaveAsTextJsonAndPage) {
  const std::string bag = SFT_TEST_DATA_DIR "/rosbag2/neato_drive_square";
  if (!std::filesystem::exists(bag)) GTEST_SKIP() << "there is no " << bag;
  const Ended ended =
      run_tool({"bag", "estimate", bag, "--like", "scan{ranges[::4]}", "--like",
                "odom{pose.pose.position}@at most 1 Hz", "--html", path("page.html"), "--json"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  const Json json = Json::parse(ended.out);
  std::map<std::string, Json> topics;
  for (const Json& topic : json["topics"]) topics[topic["topic"]] = topic;
  EXPECT_EQ(topics["scan"]["samples"], 185);
  EXPECT_EQ(topics["scan"]["fields"]["ranges"], 185 * (4 + 4 * 361));
  EXPECT_LT(topics["scan"]["selected_bytes"].get<double>(), 0.3 * topics["scan"]["bytes"].get<double>());
  EXPECT_EQ(topics["odom"]["selected_bytes"], 24 * topics["odom"]["selected_samples"].get<int>());
  EXPECT_EQ(topics["tf"]["selected_bytes"], topics["tf"]["bytes"]) << "nothing is selected of it";
  std::ifstream page(path("page.html"));
  const std::string html{std::istreambuf_iterator(page), {}};
  EXPECT_THAT(html, HasSubstr("<td>scan</td>"));
  EXPECT_THAT(run_tool({"bag", "estimate", bag}).out, HasSubstr("all: "));
  EXPECT_THAT(run_tool({"bag", "estimate", bag, "--like", "scan{rangs}"}).err, HasSubstr("ranges"));
}

}  // namespace
}  // namespace sft::test
