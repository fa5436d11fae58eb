// The thread that writes recordings. Lost samples are counted, and the memory for samples is limited.
#include "tools/sft/sample_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
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

TEST_F(SampleWriterTest, SamplesThatWereWrittenTakeNoMemoryAnyMore) {
  SampleWriter writer({.path = path(), .memory_bytes = 100'000});
  const std::size_t channel = add_channel(writer);
  for (std::uint64_t i = 1; i <= 100; ++i)
    ASSERT_TRUE(test::eventually([&] { return put(writer, channel, i, 10'000); })) << i;
  EXPECT_EQ(end(writer).samples, 100U);
  EXPECT_EQ(writer.lost(channel), 0U);
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
