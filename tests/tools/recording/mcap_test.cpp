// Writing MCAP and reading it again.
#include <sys/resource.h>

#include <csignal>
#include <random>

#include "tests/support/recorded_data.h"
#include "tests/support/test_seed.h"
#include "tests/tools/recording/recorded_file.h"
#include "tools/recording/qos_profile.h"

namespace sft::recording {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class McapTest : public McapFileTest {
 protected:
  /// Writes messages of many sizes, of which the times go forth and back.
  std::vector<Kept> write_many(const McapWriter::Options& options) const {
    std::mt19937_64 random(test::test_seed());
    McapWriter writer = create(options);
    std::vector<Kept> written;
    for (std::uint32_t i = 0; i < 300; ++i) {
      const std::size_t bytes = random() % 20 == 0 ? 300'000 : random() % 100;
      Kept kept{static_cast<std::uint16_t>(1 + random() % 3), i, 1000 + 10 * i + random() % 50,
                std::string(bytes, static_cast<char>('a' + i % 26))};
      write(writer, kept);
      written.push_back(std::move(kept));
    }
    EXPECT_TRUE(writer.close());
    std::ranges::stable_sort(written, {}, &Kept::log_ns);
    return written;
  }

  static std::vector<Kept> by_sequence(std::vector<Kept> kept) {
    std::ranges::sort(kept, {}, &Kept::sequence);
    return kept;
  }
};

TEST_F(McapTest, WhatIsWrittenIsReadInTheOrderOfTimeWithEachCompression) {
  for (const Compression compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    const std::vector<Kept> written = write_many({.compression = compression, .chunk_bytes = 1000});
    const auto reader = read();
    const std::vector<Kept> found = all_of(*reader);
    EXPECT_TRUE(std::ranges::is_sorted(found, {}, &Kept::log_ns));
    EXPECT_EQ(by_sequence(found), by_sequence(written));
    EXPECT_THAT(reader->faults(), IsEmpty());
    reader->check();
    EXPECT_THAT(reader->faults(), IsEmpty());
    std::filesystem::remove(path());
  }
}

TEST_F(McapTest, ChunksThatDoNotFitIntoMemoryTogetherAreReadAgain) {
  const std::vector<Kept> written = write_many({.compression = Compression::zstd, .chunk_bytes = 1000});
  for (const std::uint64_t memory : {1U, 3000U, 700'000U}) {
    const auto reader = read({.memory_bytes = memory});
    const std::vector<Kept> found = all_of(*reader);
    EXPECT_TRUE(std::ranges::is_sorted(found, {}, &Kept::log_ns));
    EXPECT_EQ(by_sequence(found), by_sequence(written));
    EXPECT_THAT(reader->faults(), IsEmpty());
  }
}

TEST_F(McapTest, ChunksThatWouldBeReadAgainWithoutEndAreLeftOutAndNamed) {
  write_many({.chunk_bytes = 1000});
  const auto reader = read({.memory_bytes = 1, .reread_bytes = 10'000});
  const std::vector<Kept> found = all_of(*reader);
  EXPECT_LT(found.size(), 300U);
  EXPECT_GT(found.size(), 0U);
  EXPECT_THAT(reader->faults(), ::testing::Contains(HasSubstr("its rest is left out")));
}

TEST_F(McapTest, WhoeverStopsAReaderIsToldSo) {
  {
    McapWriter writer = create({.chunk_bytes = 1});
    for (std::uint32_t i = 0; i < 10; ++i) write(writer, {1, i, 100 + i, "x"});
  }  // there is no summary, so that messages are counted
  const auto reader = read();
  int places = 0;
  reader->set_is_stopped([&places] { return ++places > 3; });
  EXPECT_LT(reader->overview().messages, 10U);
  EXPECT_THAT(reader->faults(), ::testing::Contains("reading was interrupted"));
}

TEST_F(McapTest, TheSummaryHasSchemasChannelsCountsAndMetadata) {
  McapWriter writer = create();
  write(writer, {1, 1, 100, "one"});
  write(writer, {1, 2, 300, "two"});
  write(writer, {3, 1, 200, "three"});
  EXPECT_TRUE(writer.write_metadata("sft_losses", {{"/t1", "3"}}));
  EXPECT_TRUE(writer.close());
  const auto reader = read();
  const Overview& overview = reader->overview();
  EXPECT_EQ(overview.messages, 3U);
  EXPECT_EQ(overview.first_ns, 100U);
  EXPECT_EQ(overview.last_ns, 300U);
  EXPECT_EQ(overview.of_channel, (std::map<std::uint16_t, std::uint64_t>{{1, 2}, {3, 1}}));
  EXPECT_EQ(overview.metadata.at("sft_losses").at("/t1"), "3");
  EXPECT_EQ(reader->channels().size(), 2U) << "a channel without a message is not in the file";
  EXPECT_EQ(reader->channels().at(1).metadata.at("k"), "v");
  EXPECT_EQ(reader->schemas().at(1).data, "string data\n");
  EXPECT_EQ(reader->format(), "MCAP, profile ros2, by sft");
}

TEST_F(McapTest, AReadBeginsAtATimeAndKeepsToChannels) {
  McapWriter writer = create({.chunk_bytes = 1});
  for (std::uint32_t i = 0; i < 30; ++i)
    write(writer, {static_cast<std::uint16_t>(1 + i % 3), i, 100 + i, "x"});
  EXPECT_TRUE(writer.close());
  const auto reader = read();
  const std::set<std::uint16_t> only{2};
  reader->rewind(110, &only);
  const std::vector<Kept> found = all_of(*reader);
  ASSERT_EQ(found.size(), 7U);
  EXPECT_EQ(found.front().log_ns, 110U);
  for (const Kept& one : found) EXPECT_EQ(one.channel, 2U);
}

TEST_F(McapTest, LargeMessagesHaveChunksOfTheirOwn) {
  McapWriter writer = create({.large_bytes = 1000});
  write(writer, {1, 1, 1, "small"});
  write(writer, {2, 1, 2, std::string(1000, 'l')});
  write(writer, {1, 2, 3, "small"});
  EXPECT_TRUE(writer.close());
  const auto reader = read();
  EXPECT_EQ(reader->overview().chunks.at("none"), 3U) << "definitions come first, and so does their chunk";
  EXPECT_EQ(all_of(*reader).size(), 3U);
  reader->check();
  EXPECT_THAT(reader->faults(), IsEmpty());
}

TEST_F(McapTest, AFileThatWasNotClosedHasItsChunks) {
  {
    McapWriter writer = create();
    write(writer, {1, 1, 1, "kept"});
    EXPECT_TRUE(writer.flush());
    write(writer, {1, 2, 2, "lost with the process"});
  }
  const auto reader = read();
  EXPECT_EQ(all_of(*reader), (std::vector<Kept>{{1, 1, 1, "kept"}}));
  EXPECT_EQ(reader->overview().messages, 1U);
  EXPECT_THAT(reader->faults(), ::testing::ElementsAre(HasSubstr("the file has no end")));
}

TEST_F(McapTest, AFullDiskLeavesWhatWasWrittenBefore) {
  // The limit of a file's size stands for the end of a disk: the write fails in the middle of a chunk.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  McapWriter writer = create();
  write(writer, {1, 1, 1, "kept"});
  EXPECT_TRUE(writer.flush());
  const rlimit small{writer.bytes() + 2000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string large(1 << 20, 'x');
  const Result<void> full = writer.write({.channel = 1, .log_ns = 2, .data = bytes_of(large)});
  const Result<void> closed = writer.close();
  setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_FALSE(full);
  EXPECT_THAT(full.error().message, HasSubstr("run.mcap' cannot be written: File too large"));
  const auto reader = read();
  EXPECT_EQ(all_of(*reader), (std::vector<Kept>{{1, 1, 1, "kept"}}));
  EXPECT_THAT(reader->faults(), IsEmpty()) << "there was room for the summary";
}

TEST_F(McapTest, AFileThatIsThereAlreadyIsNotTouched) {
  replace("mine");
  const Result<McapWriter> writer = McapWriter::create(path(), {});
  ASSERT_FALSE(writer);
  EXPECT_THAT(writer.error().message, HasSubstr("run.mcap' cannot be made: File exists"));
  EXPECT_EQ(content(), "mine");
}

TEST_F(McapTest, ProfilesOfAllPublishersGiveTheStrongestOffer) {
  const Qos strong{.reliability = reliable, .durability = transient_local, .history_depth = 3};
  EXPECT_EQ(from_profiles(to_profile(strong)), strong);
  EXPECT_EQ(from_profiles(to_profile(Qos{})), Qos{});
  const Qos both = from_profiles(to_profile(Qos{}) + "\n" + to_profile(strong) + "\n" + to_profile(strong));
  EXPECT_EQ(both.reliability, reliable);
  EXPECT_EQ(both.history_depth, 6U) << "the retained samples of both publishers";
  EXPECT_EQ(
      from_profiles("- history: keep_last\n  depth: 0\n  reliability: reliable\n  durability: volatile\n"),
      (Qos{.reliability = reliable}));
  EXPECT_EQ(from_profiles("nonsense: [\n- - :"), Qos{});
}

struct RecordedBag {
  const char* file;
  std::uint64_t messages;
  std::size_t types;  ///< types that have a definition in the file
};

class RecordedBags : public ::testing::TestWithParam<RecordedBag> {};

TEST_P(RecordedBags, AreReadToTheirEnd) {
  const auto file = test::recorded_data() / "rosbag2/ros2_rosbag2_tests" / GetParam().file;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  const auto bag = open_recording(file.string());
  ASSERT_TRUE(bag) << bag.error().message;
  EXPECT_EQ((*bag)->overview().messages, GetParam().messages);
  EXPECT_EQ(all_of(**bag).size(), GetParam().messages);
  (*bag)->check();
  EXPECT_THAT((*bag)->faults(), IsEmpty());
  std::size_t types = 0;
  for (const auto& [id, schema] : (*bag)->schemas()) types += type_of(schema).has_value() ? 1 : 0;
  EXPECT_EQ(types, GetParam().types);
}

INSTANTIATE_TEST_SUITE_P(Mcap, RecordedBags,
                         ::testing::Values(RecordedBag{"cdr_test_0.mcap", 7, 2},
                                           RecordedBag{"rewriter_a_0.mcap", 150, 2},
                                           RecordedBag{"rewriter_b_0.mcap", 75, 2},
                                           RecordedBag{"talker.mcap", 20, 3},
                                           RecordedBag{"topics_and_services.mcap", 13, 3}));

}  // namespace
}  // namespace sft::recording
