// Damaged and hostile MCAP files. Errors name the record and its offset, and everything that can be read is
// read.
#include <lz4frame.h>
#include <sys/stat.h>
#include <zstd.h>

#include <random>

#include "tests/support/test_seed.h"
#include "tests/tools/recording/recorded_file.h"

namespace sft::recording {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class HostileMcap : public McapFileTest {
 protected:
  /// Writes a file with a message in each of `chunks` chunks.
  void make(std::uint32_t chunks, Compression compression = Compression::none) const {
    McapWriter writer = create({.compression = compression, .chunk_bytes = 1});
    for (std::uint32_t i = 0; i < chunks; ++i) write(writer, {1, i, 100 + i, "message " + std::to_string(i)});
    ASSERT_TRUE(writer.close());
  }
  static void put(std::string& content, std::size_t at, std::uint64_t number) {
    std::memcpy(content.data() + at, &number, sizeof number);
  }
  /// Appends a record with this content.
  static void add(std::string& content, Opcode opcode, const std::string& record) {
    content += static_cast<char>(opcode);
    const std::uint64_t length = record.size();
    content.append(reinterpret_cast<const char*>(&length), sizeof length);
    content += record;
  }
  /// The content of a chunk record whose records are compressed like this, and said to have `size` bytes.
  static std::string chunk(std::uint64_t size, const std::string& compression,
                           const std::string& compressed) {
    Bytes bytes;
    ByteWriter to(bytes);
    to.number(std::uint64_t{1});
    to.number(std::uint64_t{1});
    to.number(size);
    to.number(std::uint32_t{0});
    to.text(compression);
    to.number(static_cast<std::uint64_t>(compressed.size()));
    to.raw(bytes_of(compressed));
    return text_of(bytes);
  }
};

TEST_F(HostileMcap, AFileThatEndsAnywhereIsReadUpToThere) {
  make(5);
  const std::string whole = content();
  std::size_t most = 0;
  for (std::size_t length = magic.size(); length < whole.size(); ++length) {
    replace(whole.substr(0, length));
    const auto reader = read();
    const std::size_t found = all_of(*reader).size();
    EXPECT_GE(found, most) << "a longer file has no fewer messages";
    EXPECT_THAT(reader->faults(), Not(IsEmpty())) << length;
    most = found;
  }
  EXPECT_EQ(most, 5U);
}

TEST_F(HostileMcap, AnythingElseIsNoMcap) {
  for (const char* const other : {"", "x", "\x89MCAP1\r\n", "SQLite format 4"}) {
    replace(other);
    const auto opened = open_recording(path());
    ASSERT_FALSE(opened);
    EXPECT_THAT(opened.error().message, HasSubstr("run.mcap' is no MCAP file"));
  }
}

TEST_F(HostileMcap, LengthsOfTwoToThe63AreNamedWithTheirRecord) {
  make(3);
  std::string damaged = content();
  const std::size_t second = damaged.find('\x06', damaged.find("message 0"));
  put(damaged, second + 1, std::uint64_t{1} << 63);
  replace(damaged);
  const auto reader = read();
  EXPECT_EQ(all_of(*reader).size(), 2U) << "the summary names the chunk behind the damaged one";
  EXPECT_THAT(reader->faults(), Contains(HasSubstr("Chunk at offset " + std::to_string(second) +
                                                   ": it names 9223372036854775808 bytes")));
}

TEST_F(HostileMcap, ChunksThatNameHugeContentsTakeNoMemory) {
  for (const std::uint64_t size : {std::uint64_t{1} << 63, std::uint64_t{1} << 29}) {
    std::string file(magic);
    add(file, Opcode::chunk, chunk(size, "zstd", "nothing"));
    add(file, Opcode::chunk, chunk(size, "lz4", "nothing"));
    add(file, Opcode::chunk, chunk(size, "", "nothing"));
    add(file, Opcode::chunk, chunk(size, "bzip2", "nothing"));
    replace(file);
    const auto reader = read();
    EXPECT_THAT(all_of(*reader), IsEmpty());
    EXPECT_THAT(reader->faults(), Contains(HasSubstr("Chunk at offset 8: ")));
    EXPECT_GE(reader->faults().size(), 4U);
  }
}

TEST_F(HostileMcap, BombsAreStoppedAtTheSizeThatTheChunkNames) {
  const std::string zeros(std::size_t{64} << 20, '\0');
  std::string zstd(ZSTD_compressBound(zeros.size()), '\0');
  zstd.resize(ZSTD_compress(zstd.data(), zstd.size(), zeros.data(), zeros.size(), 1));
  std::string lz4(LZ4F_compressFrameBound(zeros.size(), nullptr), '\0');
  lz4.resize(LZ4F_compressFrame(lz4.data(), lz4.size(), zeros.data(), zeros.size(), nullptr));
  std::string file(magic);
  add(file, Opcode::chunk, chunk(1000, "zstd", zstd));
  add(file, Opcode::chunk, chunk(1000, "lz4", lz4));
  replace(file);
  const auto reader = read();
  EXPECT_THAT(all_of(*reader), IsEmpty());
  EXPECT_THAT(reader->faults(), Contains(HasSubstr("its contents do not have the 1000 bytes that it says")));
}

TEST_F(HostileMcap, AFlippedByteCostsItsChunkAndNoOther) {
  for (const Compression compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    make(20, compression);
    std::string damaged = content();
    // In the middle of the sixth chunk; each begins with its opcode and the time of its message.
    std::string time(8, '\0');
    put(time, 0, 105);
    const std::size_t at = damaged.find(time + time);
    ASSERT_NE(at, damaged.npos);
    const std::size_t records = at + 8 + 8 + 8 + 4 + 4 + name_of(compression).size() + 8;
    damaged[records + 20] = static_cast<char>(damaged[records + 20] ^ 0x10);
    replace(damaged);
    const auto reader = read();
    std::vector<Kept> found = all_of(*reader);
    EXPECT_EQ(found.size(), 19U);
    for (const Kept& one : found) EXPECT_NE(one.sequence, 5U);
    EXPECT_THAT(reader->faults(),
                ::testing::ElementsAre(::testing::AllOf(
                    HasSubstr("Chunk at offset " + std::to_string(at - 9)), HasSubstr("left out"))));
    std::filesystem::remove(path());
  }
}

TEST_F(HostileMcap, CheckFindsEachFlippedByteOfAnIndexAndOfTheSummary) {
  make(3);
  const std::string whole = content();
  const auto reader = read();
  std::size_t unnoticed = 0;
  for (std::size_t at = magic.size(); at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x01);
    replace(damaged);
    const auto opened = McapReader::open(File::open(path()).value());
    ASSERT_TRUE(opened);
    (*opened)->check();
    unnoticed += (*opened)->faults().empty() ? 1 : 0;
  }
  EXPECT_EQ(unnoticed, 0U) << "all bytes are below a checksum";
}

TEST_F(HostileMcap, MessagesOfUnknownChannelsAreLeftOutAndNamed) {
  std::string file(magic);
  std::string message(message_head_bytes, '\0');
  message[0] = 9;
  add(file, Opcode::message, message + "data");
  add(file, Opcode::message, "short");
  replace(file);
  const auto reader = read();
  EXPECT_THAT(all_of(*reader), IsEmpty());
  EXPECT_THAT(reader->faults(), Contains(HasSubstr("channel 9 has messages")));
  EXPECT_THAT(reader->faults(), Contains(HasSubstr("Message at offset")));
}

TEST_F(HostileMcap, MessagesWithoutChunksAndIndexesAreRead) {
  std::string file(magic);
  Bytes channel;
  ByteWriter to(channel);
  to.number(std::uint16_t{7});
  to.number(std::uint16_t{0});
  to.text("/bare");
  to.text("cdr");
  to.texts({});
  add(file, Opcode::channel, text_of(channel));
  for (const char time : {'\x03', '\x01', '\x02'}) {
    std::string message(message_head_bytes, '\0');
    message[0] = 7;
    message[6] = time;
    add(file, Opcode::message, message + time);
  }
  add(file, Opcode::data_end, std::string(4, '\0'));
  add(file, Opcode::footer, std::string(20, '\0'));
  replace(file + std::string(magic));
  const auto reader = read();
  const std::vector<Kept> found = all_of(*reader);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].data, "\x01");
  EXPECT_EQ(found[2].data, "\x03");
  EXPECT_EQ(reader->overview().messages, 3U) << "they are counted, since no statistics are there";
  EXPECT_THAT(reader->faults(), IsEmpty());
  EXPECT_FALSE(reader->schemas().contains(0));
}

TEST_F(HostileMcap, DefinitionsWithinChunksHaveTheSameLimitAsOthers) {
  McapWriter writer = create();
  for (std::uint16_t id = 10; id < 60; ++id) {
    writer.declare(Channel{.id = id, .schema = 1, .topic = "/" + std::string(20, 't')});
    write(writer, {id, 1, 100, "x"});
  }
  EXPECT_TRUE(writer.flush());
  const auto of_one = read({.text_bytes = 50});
  (void)all_of(*of_one);
  EXPECT_TRUE(of_one->schemas().empty());
  EXPECT_THAT(of_one->faults(), Contains(::testing::ContainsRegex("Schema at offset [0-9]+: .* too many")));
  const auto of_all = read({.text_bytes = 60});
  EXPECT_LT(all_of(*of_all).size(), 50U) << "each is small, and all together are too large";
  EXPECT_THAT(of_all->faults(), Contains(::testing::ContainsRegex("Channel at offset [0-9]+: .* too many")));
}

TEST_F(HostileMcap, AFifoIsNoRecordingAndIsNotWaitedFor) {
  ASSERT_EQ(mkfifo(path().c_str(), 0600), 0);
  const auto opened = open_recording(path());
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, HasSubstr("run.mcap' cannot be read: it is no file with contents"));
}

TEST_F(HostileMcap, RandomDamageNeitherCrashesNorHangsAReader) {
  make(10, Compression::zstd);
  const std::string whole = content();
  std::mt19937_64 random(test::test_seed());
  for (int round = 0; round < 500; ++round) {
    std::string damaged = whole;
    for (unsigned i = 0; i < 1 + random() % 8; ++i) {
      const std::size_t at = magic.size() + random() % (damaged.size() - magic.size());
      damaged[at] = static_cast<char>(random());
    }
    replace(damaged);
    const auto reader = read();
    EXPECT_LE(all_of(*reader).size(), 20U);
    reader->check();
    (void)reader->overview();
  }
}

}  // namespace
}  // namespace sft::recording
