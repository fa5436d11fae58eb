// The thread that writes recordings. Lost samples are counted, and the memory for samples is limited.
#include "tools/sft/sample_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/support/eventually.h"
#include "tests/support/temporary_directory.h"
#include "tools/recording/open_recording.h"

namespace sft::tool {
namespace {

using namespace std::chrono_literals;

class SampleWriterTest : public ::testing::Test {
 protected:
  static constexpr std::uint64_t second = 1'000'000'000;

  static std::size_t add_channel(SampleWriter& writer, std::uint32_t retained = 0) {
    return writer.add_channel({.name = "std_msgs/msg/String", .encoding = "ros2msg", .data = "string data\n"},
                              {.topic = "/t"}, retained);
  }
  static bool put(SampleWriter& writer, std::size_t channel, std::uint64_t log_ns, std::size_t bytes = 100) {
    const std::vector<std::byte> data(bytes);
    return writer.put(channel, {.log_ns = log_ns, .publish_ns = log_ns, .data = data});
  }
  static SampleWriter::Status end(SampleWriter& writer) {
    writer.finish();
    while (!writer.status().is_over) std::this_thread::yield();
    return writer.status();
  }
  /// The log times of the messages in a file, in seconds.
  std::vector<double> seconds_in(const std::string& name) const {
    std::vector<double> times;
    const auto file = recording::open_recording(path(name)).value();
    while (const auto message = file->next())
      times.push_back(static_cast<double>(message->log_ns) / static_cast<double>(second));
    return times;
  }
  std::string path(const std::string& name = "run.mcap") const { return (folder.path() / name).string(); }

  test::TemporaryDirectory folder;
};

TEST_F(SampleWriterTest, WhatADiskRefusesIsLostAndNotCountedAsWritten) {
  // The limit of a file's size stands for the end of a disk: the begin of the file fits, and no chunk, even
  // one of a single sample.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{500, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  SampleWriter writer({.path = path()});
  const std::size_t first = add_channel(writer), second_channel = add_channel(writer);
  // Samples are refused as soon as the disk has refused the first chunk, which may contain one sample or
  // more.
  std::uint64_t of_first = 0, of_second = 0;
  for (std::uint64_t i = 1; i <= 10; ++i) {
    of_first += put(writer, first, i, 500) ? 1 : 0;
    of_second += put(writer, second_channel, i, 500) ? 1 : 0;
  }
  const SampleWriter::Status status = end(writer);
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(status.fault, ::testing::HasSubstr("run.mcap' cannot be written: File too large"));
  EXPECT_EQ(status.samples, 0U);
  EXPECT_GE(of_first, 1U);
  EXPECT_EQ(writer.lost(first), of_first);
  EXPECT_EQ(writer.lost(second_channel), of_second);
  EXPECT_FALSE(put(writer, first, 12));
}

TEST_F(SampleWriterTest, WhatIsWrittenIsCountedAndNotLost) {
  SampleWriter writer({.path = path()});
  const std::size_t channel = add_channel(writer);
  for (std::uint64_t i = 1; i <= 10; ++i) EXPECT_TRUE(put(writer, channel, i));
  const SampleWriter::Status status = end(writer);
  EXPECT_EQ(status.samples, 10U);
  EXPECT_EQ(writer.lost(channel), 0U);
}

TEST_F(SampleWriterTest, ATimeThatGoesBackBehindATriggerEndsWhatIsWrittenForIt) {
  SampleWriter writer({.path = path(), .window = 10s});
  const std::size_t channel = add_channel(writer);
  EXPECT_TRUE(put(writer, channel, 100 * second));
  writer.trigger(100 * second);
  EXPECT_TRUE(put(writer, channel, 100 * second + second / 2));
  EXPECT_TRUE(put(writer, channel, 1 * second));
  EXPECT_EQ(end(writer).samples, 2U) << "the last one is in the window, and no trigger comes";
}

/// The recorder takes the sample that fulfils a condition by two subscribers, in any order.
TEST_F(SampleWriterTest, TheSampleThatHasCausedATriggerIsWrittenAlsoIfItComesAfterTheTrigger) {
  SampleWriter writer({.path = path(), .window = 100s});
  const std::size_t channel = add_channel(writer);
  EXPECT_TRUE(put(writer, channel, 100 * second));
  writer.trigger(110 * second);
  EXPECT_TRUE(put(writer, channel, 110 * second));
  EXPECT_EQ(end(writer).samples, 2U);
}

TEST_F(SampleWriterTest, ATriggerWritesTheWindowAndOneSecondMore) {
  SampleWriter writer({.path = path(), .window = 3s});
  const std::size_t channel = add_channel(writer);
  for (std::uint64_t time = 1; time <= 10; ++time) EXPECT_TRUE(put(writer, channel, time * second));
  writer.trigger(10 * second);
  for (const std::uint64_t more : {second / 2, second, second + 1, 3 * second / 2})
    EXPECT_TRUE(put(writer, channel, 10 * second + more));
  EXPECT_EQ(end(writer).samples, 6U);
  EXPECT_THAT(seconds_in("run_0.mcap"), ::testing::ElementsAre(7, 8, 9, 10, 10.5, 11));
  EXPECT_EQ(writer.lost(channel), 0U) << "nobody has asked for the others";
}

TEST_F(SampleWriterTest, EachWindowHasItsFileOnceTheTimeOfTheLastOneIsOver) {
  SampleWriter writer({.path = path(), .window = 3s});
  const std::size_t channel = add_channel(writer);
  const auto triggered_at = [&](std::uint64_t time) {
    EXPECT_TRUE(put(writer, channel, time * second));
    writer.trigger(time * second);
  };
  triggered_at(10);
  EXPECT_TRUE(put(writer, channel, 13 * second));
  triggered_at(14);
  EXPECT_TRUE(put(writer, channel, 18 * second));
  triggered_at(20);
  const SampleWriter::Status status = end(writer);
  EXPECT_EQ(status.samples, 5U);
  EXPECT_THAT(status.files,
              ::testing::ElementsAre(path("run_0.mcap"), path("run_1.mcap"), path("run_2.mcap")));
  EXPECT_THAT(seconds_in("run_0.mcap"), ::testing::ElementsAre(10));
  EXPECT_THAT(seconds_in("run_1.mcap"), ::testing::ElementsAre(13, 14));
  EXPECT_THAT(seconds_in("run_2.mcap"), ::testing::ElementsAre(18, 20));
}

TEST_F(SampleWriterTest, TriggersThatFollowEachOtherWriteEachSampleOnceAndIntoOneFile) {
  SampleWriter writer({.path = path(), .window = 10s});
  const std::size_t channel = add_channel(writer);
  for (const std::uint64_t time : {10, 12, 14, 15}) {
    EXPECT_TRUE(put(writer, channel, time * second));
    writer.trigger(time * second);
  }
  const SampleWriter::Status status = end(writer);
  EXPECT_EQ(status.samples, 4U);
  EXPECT_EQ(status.files.size(), 1U);
  EXPECT_THAT(seconds_in("run_0.mcap"), ::testing::ElementsAre(10, 12, 14, 15));
}

TEST_F(SampleWriterTest, AFileThatIsSplitByTimeEndsBeforeItsTimeIsOverAndAllAreCounted) {
  SampleWriter writer({.path = path(), .split_time = 10s});
  const std::size_t channel = add_channel(writer);
  for (const std::uint64_t time : {5, 14, 15, 20, 25}) EXPECT_TRUE(put(writer, channel, time * second));
  const SampleWriter::Status status = end(writer);
  EXPECT_THAT(seconds_in("run_0.mcap"), ::testing::ElementsAre(5, 14));
  EXPECT_THAT(seconds_in("run_1.mcap"), ::testing::ElementsAre(15, 20));
  EXPECT_THAT(seconds_in("run_2.mcap"), ::testing::ElementsAre(25));
  EXPECT_EQ(status.samples, 5U);
  std::uint64_t bytes = 0;
  for (const std::string& file : status.files) bytes += std::filesystem::file_size(file);
  EXPECT_EQ(status.bytes, bytes);
  EXPECT_EQ(writer.lost(channel), 0U);
}

TEST_F(SampleWriterTest, EachFileBeginsWithAsManySamplesAsAreRetainedAndNoneOfThemIsLost) {
  SampleWriter writer({.path = path(), .split_time = 10s});
  const std::size_t latched = add_channel(writer, 2), plain = add_channel(writer);
  for (const std::uint64_t time : {1, 2, 3}) EXPECT_TRUE(put(writer, latched, time * second));
  for (const std::uint64_t time : {4, 20}) EXPECT_TRUE(put(writer, plain, time * second));
  EXPECT_EQ(end(writer).samples, 7U) << "two are in both files";
  EXPECT_THAT(seconds_in("run_0.mcap"), ::testing::ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(seconds_in("run_1.mcap"), ::testing::ElementsAre(20, 20, 20));
  EXPECT_EQ(writer.lost(latched), 0U);
  EXPECT_EQ(writer.lost(plain), 0U);
}

TEST_F(SampleWriterTest, WhatComesAfterAFileThatCannotBeMadeIsLost) {
  SampleWriter writer({.path = path(), .split_time = 10s});
  std::ofstream(path("run_1.mcap")) << "mine";
  const std::size_t channel = add_channel(writer), other = add_channel(writer);
  EXPECT_TRUE(put(writer, channel, 1 * second));
  std::uint64_t accepted = 0;
  for (const std::uint64_t time : {20, 21, 22}) accepted += put(writer, channel, time * second) ? 1 : 0;
  const SampleWriter::Status status = end(writer);
  EXPECT_THAT(status.fault, ::testing::HasSubstr("run_1.mcap' cannot be made: File exists"));
  EXPECT_THAT(status.files, ::testing::ElementsAre(path("run_0.mcap")));
  EXPECT_EQ(status.samples, 1U);
  EXPECT_GE(accepted, 1U);
  EXPECT_EQ(writer.lost(channel), accepted);
  EXPECT_EQ(writer.lost(other), 0U);
}

TEST_F(SampleWriterTest, ChannelsOfOneDefinitionShareItsSchemaAndOthersDoNot) {
  SampleWriter writer({.path = path(), .about = {{"clock", "system"}}});
  const auto channel_of = [&](const std::string& definition, const std::string& topic) {
    return writer.add_channel({.name = "a/msg/B", .encoding = "ros2msg", .data = definition},
                              {.topic = topic}, 0);
  };
  const std::array channels{channel_of("int32 a\n", "/one"), channel_of("int32 b\n", "/two"),
                            channel_of("int32 a\n", "/three")};
  for (const std::size_t channel : channels) EXPECT_TRUE(put(writer, channel, 1));
  end(writer);
  const auto file = recording::open_recording(path()).value();
  while (file->next()) {
  }
  std::map<std::string, std::string> definitions;
  for (const auto& [id, channel] : file->channels())
    definitions[channel.topic] = file->schemas().at(channel.schema).data;
  EXPECT_EQ(definitions, (std::map<std::string, std::string>{
                             {"/one", "int32 a\n"}, {"/two", "int32 b\n"}, {"/three", "int32 a\n"}}));
  EXPECT_EQ(file->schemas().size(), 2U);
  EXPECT_EQ(file->overview().metadata.at("sft_recording").at("clock"), "system");
  EXPECT_FALSE(file->overview().metadata.contains("sft_losses")) << "there were none";
}

TEST_F(SampleWriterTest, LossesAreInTheMetadataOfEachFile) {
  SampleWriter writer({.path = path(), .split_time = 10s});
  const std::size_t channel = add_channel(writer);
  writer.set_losses({{"/t", "3"}});
  EXPECT_TRUE(put(writer, channel, 1 * second));
  EXPECT_TRUE(put(writer, channel, 20 * second));
  end(writer);
  for (const char* const name : {"run_0.mcap", "run_1.mcap"}) {
    const auto file = recording::open_recording(path(name)).value();
    EXPECT_EQ(file->overview().metadata.at("sft_losses").at("/t"), "3") << name;
  }
}

TEST_F(SampleWriterTest, SamplesThatWereWrittenTakeNoMemoryAnyMore) {
  SampleWriter writer({.path = path(), .memory_bytes = 100'000});
  const std::size_t channel = add_channel(writer);
  for (std::uint64_t i = 1; i <= 100; ++i)
    ASSERT_TRUE(test::eventually([&] { return put(writer, channel, i, 10'000); })) << i;
  EXPECT_EQ(end(writer).samples, 100U);
  EXPECT_EQ(writer.lost(channel), 0U);
}

TEST_F(SampleWriterTest, AWindowForWhichThereIsTooLittleMemoryKeepsItsNewestSamples) {
  SampleWriter writer({.path = path(), .memory_bytes = 100'000, .window = 1000s});
  const std::size_t channel = add_channel(writer);
  for (std::uint64_t i = 1; i <= 50; ++i)
    ASSERT_TRUE(test::eventually([&] { return put(writer, channel, i * second, 10'000); })) << i;
  writer.trigger(50 * second);
  end(writer);
  const std::vector<double> times = seconds_in("run_0.mcap");
  EXPECT_EQ(times.back(), 50);
  EXPECT_GE(times.size(), 6U) << "three quarters of the memory are for the window";
  EXPECT_LE(times.size(), 9U);
}

TEST_F(SampleWriterTest, RetainedSamplesCountAsMemory) {
  SampleWriter writer({.path = path(), .memory_bytes = 100'000});
  const std::size_t channel = add_channel(writer, 128);
  std::uint64_t accepted = 0;
  for (std::uint64_t i = 1; i <= 100; ++i) accepted += put(writer, channel, i, 10'000) ? 1 : 0;
  EXPECT_LT(accepted, 10U);
}

TEST_F(SampleWriterTest, EmptySamplesTakeMemoryToo) {
  SampleWriter writer({.path = path(), .memory_bytes = 10'000});
  const std::size_t channel = add_channel(writer, 128);
  std::uint64_t accepted = 0;
  for (std::uint64_t i = 1; i <= 128; ++i) accepted += put(writer, channel, i, 0) ? 1 : 0;
  EXPECT_LT(accepted, 128U);
}

}  // namespace
}  // namespace sft::tool
