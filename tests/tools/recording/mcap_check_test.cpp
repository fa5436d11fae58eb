// check() compares what a file says of itself with its records. The files of this test have no checksums,
// which would show each change before anything is compared.
#include "tests/tools/recording/recorded_file.h"
#include "tools/recording/block.h"

namespace sft::recording {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class McapCheckTest : public McapFileTest {
 protected:
  void SetUp() override {
    {
      McapWriter writer = create();
      write(writer, {1, 1, 100, "one"});
      write(writer, {3, 1, 200, "three"});
      write(writer, {1, 2, 300, "two"});
      ASSERT_TRUE(writer.close());
    }
    file = content();
    footer = file.size() - magic.size() - record_head_bytes - 20;
    summary = get<std::uint64_t>(footer + record_head_bytes);
    data_end = summary - record_head_bytes - 4;
    const std::size_t chunk_crc = find(Opcode::chunk) + 24;
    for (const std::size_t crc : {footer + record_head_bytes + 16, data_end + record_head_bytes, chunk_crc})
      put(crc, std::uint32_t{0});
  }

  template <class I>
  I get(std::size_t at) const {
    I value{};
    std::memcpy(&value, file.data() + at, sizeof value);
    return value;
  }
  template <class I>
  void put(std::size_t at, I value) {
    std::memcpy(file.data() + at, &value, sizeof value);
  }
  /// Returns the position of the content of the first such record of the file.
  std::size_t find(Opcode opcode) const {
    std::size_t found = 0;
    walk(bytes_of(file).subspan(magic.size(), footer - magic.size()),
         {[&](Opcode kind, std::span<const std::byte>, std::uint64_t offset) {
            if (kind == opcode && found == 0) found = magic.size() + offset + record_head_bytes;
          },
          [](std::uint64_t, const std::string& what) { ADD_FAILURE() << what; }});
    EXPECT_NE(found, 0U);
    return found;
  }
  std::vector<std::string> faults() const {
    replace(file);
    const auto reader = read();
    for (int i = 0; i < 2; ++i) reader->check();  // each fault is told once
    return reader->faults();
  }

  std::string file;
  std::size_t footer = 0, summary = 0,
              data_end = 0;  ///< positions of the records, and of the summary's begin
};

TEST_F(McapCheckTest, AFileThatDescribesItselfAsItIsHasNoFaults) { EXPECT_THAT(faults(), IsEmpty()); }

TEST_F(McapCheckTest, StatisticsAreThoseOfTheMessages) {
  const std::size_t statistics = find(Opcode::statistics);
  put(statistics, std::uint64_t{4});
  EXPECT_THAT(faults(), ElementsAre("the statistics count 4 messages in 1 chunks, and there are 3 in 1"));
  put(statistics, std::uint64_t{3});
  put(statistics + 22, std::uint32_t{2});
  EXPECT_THAT(faults(), ElementsAre("the statistics count 3 messages in 2 chunks, and there are 3 in 1"));
  put(statistics + 22, std::uint32_t{1});
  ASSERT_EQ(get<std::uint64_t>(statistics + 48), 2U) << "channel 1";
  put(statistics + 48, std::uint64_t{1});
  EXPECT_THAT(faults(), ElementsAre("the statistics count other messages of each channel than there are"));
}

TEST_F(McapCheckTest, TheSummaryDescribesEachChunkAsItIs) {
  const std::size_t index = find(Opcode::chunk_index);
  const std::string as_written = file;
  for (const std::size_t time : {index, index + 8}) {
    put(time, get<std::uint64_t>(time) + 1);
    EXPECT_THAT(faults(), ElementsAre(HasSubstr(": the summary describes it in another way")));
    file = as_written;
  }
  const auto offset = get<std::uint64_t>(index + 16);
  put(index + 16, offset + 1);
  EXPECT_THAT(
      faults(),
      UnorderedElementsAre("Chunk at offset " + std::to_string(offset) + ": the summary does not have it",
                           "the summary names a chunk at " + std::to_string(offset + 1) + ", where none is"));
}

TEST_F(McapCheckTest, TheTimesOfAChunkAreThoseOfItsFirstAndItsLastMessage) {
  const std::string as_written = file;
  const std::size_t chunk = find(Opcode::chunk), index = find(Opcode::chunk_index);
  for (const std::size_t time : {std::size_t{0}, std::size_t{8}}) {
    put(chunk + time, get<std::uint64_t>(chunk + time) + 1);
    put(index + time, get<std::uint64_t>(chunk + time));
    EXPECT_THAT(faults(), ElementsAre(HasSubstr(": its first and last times are not those of its messages")));
    file = as_written;
  }
}

TEST_F(McapCheckTest, MessageIndexesAreThoseOfTheMessages) {
  const std::size_t index = find(Opcode::message_index);
  const std::string as_written = file;
  const auto are_wrong =
      ElementsAre(HasSubstr(": the message indexes behind it are not those of its messages"));
  put(index, std::uint16_t{2});  // the channel
  EXPECT_THAT(faults(), are_wrong);
  file = as_written;
  put(index + 6, get<std::uint64_t>(index + 6) + 1);  // the time of the first message
  EXPECT_THAT(faults(), are_wrong);
  file = as_written;
  put(index + 14, get<std::uint64_t>(index + 14) + 1);  // its offset
  EXPECT_THAT(faults(), are_wrong);
  file = as_written;
  file[index + 6 + 32] = '\x7f';  // the index of the other channel, which is of no known kind now
  EXPECT_THAT(faults(), are_wrong);
}

TEST_F(McapCheckTest, ChecksumsAndTheEndOfTheDataAreLookedAt) {
  put(data_end + record_head_bytes, std::uint32_t{1});
  put(footer + record_head_bytes + 16, std::uint32_t{1});
  EXPECT_THAT(faults(), UnorderedElementsAre("the checksum of the data section is wrong",
                                             "the checksum of the summary is wrong"));
  put(footer + record_head_bytes + 16, std::uint32_t{0});
  file[data_end] = '\x7f';
  EXPECT_THAT(faults(), ElementsAre("the file has a summary, but no DataEnd record in front of it"));
}

TEST_F(McapCheckTest, AttachmentsAreReadUnlessTheirChecksumIsWrong) {
  std::filesystem::remove(path());
  std::string attachment(8 + 8, '\0');
  const auto add = [&](auto number) {
    attachment.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  add(std::uint32_t{1});
  attachment += 'a';
  add(std::uint32_t{0});
  add(std::uint64_t{3});
  attachment += "abc";
  add(crc32(0, bytes_of(attachment)));
  McapWriter writer = create();
  ASSERT_TRUE(writer.write_attachment(bytes_of(attachment)));
  ASSERT_TRUE(writer.close());
  std::vector<std::string> found;
  const auto read_all = [&] {
    found.clear();
    const auto reader = read();
    EXPECT_EQ(reader->overview().attachments.at("a"), 3U);
    reader->read_attachments([&](const Bytes& bytes) { found.push_back(text_of(bytes)); });
    return reader->faults();
  };
  EXPECT_THAT(read_all(), IsEmpty());
  EXPECT_THAT(found, ElementsAre(attachment));
  file = content();
  file[file.find("abc")] = 'x';
  replace(file);
  EXPECT_THAT(read_all(), ElementsAre(::testing::MatchesRegex(
                              "Attachment at offset [0-9]+: its checksum is wrong; it is left out")));
  EXPECT_THAT(found, IsEmpty());
}

TEST_F(McapCheckTest, WhereAFileHasNoStatisticsItsMessagesAreCounted) {
  std::filesystem::remove(path());
  {
    McapWriter writer = create();
    write(writer, {2, 1, 250, "b"});
    write(writer, {2, 2, 300, "d"});
    EXPECT_TRUE(writer.flush());
    write(writer, {1, 1, 100, "a"});
    write(writer, {2, 3, 400, "c"});
    EXPECT_TRUE(writer.flush());
  }
  const auto reader = read();
  for (int i = 0; i < 2; ++i) {
    const Overview& overview = reader->overview();
    EXPECT_EQ(overview.messages, 4U) << "they are counted once";
    EXPECT_EQ(overview.first_ns, 100U);
    EXPECT_EQ(overview.last_ns, 400U);
    EXPECT_EQ(overview.of_channel, (std::map<std::uint16_t, std::uint64_t>{{1, 1}, {2, 3}}));
    EXPECT_EQ(overview.chunks, (std::map<std::string, std::uint64_t>{{"none", 2}}));
  }
}

TEST_F(McapCheckTest, AChannelMayBeDefinedBehindItsMessagesInTime) {
  std::filesystem::remove(path());
  {
    McapWriter writer = create();
    write(writer, {2, 1, 300, "later"});
    EXPECT_TRUE(writer.flush());
    write(writer, {2, 2, 100, "earlier"});
    EXPECT_TRUE(writer.flush());
  }  // as a recorder that is killed leaves it
  EXPECT_EQ(all_of(*read()), (std::vector<Kept>{{2, 2, 100, "earlier"}, {2, 1, 300, "later"}}));
  const auto reader = read();
  reader->check();
  EXPECT_THAT(reader->faults(), ElementsAre(HasSubstr("the file has no end")));
}

TEST_F(McapCheckTest, AFaultIsToldOnceAndOfVeryManyTheFirstThousand) {
  std::string many(magic);
  for (int i = 0; i < 1500; ++i) many += std::string("\x05\x05\0\0\0\0\0\0\0short", 14);
  replace(many);
  const auto reader = read();
  EXPECT_EQ(reader->faults().size(), 1001U);
  EXPECT_EQ(reader->faults().back(), "there are more faults");
  EXPECT_EQ(reader->faults().front(), "Message at offset 8: its content ends early");
}

}  // namespace
}  // namespace sft::recording
