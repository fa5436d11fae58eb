// Writers and readers are killed with SIGKILL at random moments. No other program is disturbed, and the
// chunks of the killed programs become free again.
#include <signal.h>

#include <filesystem>
#include <optional>
#include <span>

#include "shm_transport/host/host_file.h"
#include "shm_transport/host/session.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::SampleHandle;
using core::SendStatus;

constexpr std::uint32_t megabyte = 1'000'000;

class Kill : public ShmNodeTest {
 protected:
  // Leaves room for the chunks of dead programs, which are missing until sftd has noticed the deaths.
  Kill() : ShmNodeTest(1024) {}
};

TEST_F(Kill, OfAWriterInATightLoopBlocksNobody) {
  constexpr int rounds = 20;
  constexpr std::uint32_t frame = 60'000;
  ChunkCounter chunks(node(), frame);
  const std::size_t before = chunks.free();
  const std::string token = shm::format(shm::HostMonitor::look({.everybody = true}).monitor->file());
  for (int round = 1; round <= rounds; ++round) {
    const auto id = static_cast<core::EndpointId>(round);
    Process peer = start_peer({"publish", std::to_string(id), std::to_string(frame)});
    ASSERT_EQ(peer.line(), "publishing");
    Reader reader(node());
    ASSERT_TRUE(reader.connects_to(id)) << round;
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(reader.next()) << round;
    peer.kill();
    Writer writer(node(), 1000 + id);
    ASSERT_EQ(writer.send_frame(), SendStatus::sent) << round;
  }
  EXPECT_EQ(shm::format(shm::HostMonitor::look({.everybody = true}).monitor->file()), token)
      << "the daemon did not survive";
  EXPECT_TRUE(chunks.comes_to(before));
}

TEST_F(Kill, OfAReaderInATightLoopCostsAtMostTheChunkThatItWasTakingUntilTheWriterGoes) {
  std::optional<Writer> writer(std::in_place, node(), 1);
  ChunkCounter chunks(node(), megabyte);
  const std::size_t before = chunks.free();
  constexpr int rounds = 10;
  for (int round = 0; round < rounds; ++round) {
    Process peer = start_peer({"subscribe", "1"});
    ASSERT_EQ(peer.line(), "subscribed") << round;
    for (int i = 0; i < 2000; ++i) writer->send_frame(megabyte);
    peer.kill();
    ASSERT_EQ(writer->send_frame(megabyte), SendStatus::sent) << round;
  }
  // One chunk stays in use by the writer. iceoryx loses a chunk if a reader dies after it has taken the chunk
  // from the queue and before it has recorded the chunk. Here that happens about once in a thousand kills.
  EXPECT_TRUE(chunks.comes_to(before - 1 - rounds)) << "more than one chunk per kill is lost";
  writer.reset();
  EXPECT_TRUE(chunks.comes_to(before));
}

TEST_F(Kill, OfAWriterReturnsItsLoansAndItsHistory) {
  ChunkCounter chunks(node(), megabyte);
  const std::size_t before = chunks.free();
  Process peer = start_peer({"hoard", "1", std::to_string(megabyte)});
  EXPECT_EQ(peer.line(), "hoarded");
  EXPECT_LE(chunks.free(), before - 16);
  peer.kill();
  EXPECT_TRUE(chunks.comes_to(before));
}

TEST_F(Kill, OfAWriterReturnsItsChunksThoughAForkedCopyOfItLivesOn) {
  ChunkCounter chunks(node(), megabyte);
  const std::size_t before = chunks.free();
  Process peer = start_peer({"hoard-with-a-worker", "1", std::to_string(megabyte)});
  EXPECT_EQ(peer.line(), "hoarded");
  EXPECT_LE(chunks.free(), before - 16);
  peer.kill();
  EXPECT_TRUE(chunks.comes_to(before));
  EXPECT_TRUE(eventually([] { return names_in("/tmp", "sft_node").size() == 1; }));
}

TEST_F(Kill, OfAWriterLeavesItsSamplesToTheReadersThatHoldThem) {
  Reader reader(node());
  Process peer = start_peer({"publish", "1"});
  ASSERT_EQ(peer.line(), "publishing");
  ASSERT_TRUE(reader.connects_to(1));
  const SampleHandle sample = reader.next();
  ASSERT_TRUE(sample);
  const std::uint64_t sequence = sequence_of(sample);
  peer.kill();
  EXPECT_TRUE(eventually([&] { return !reader.port().connected(1); }));
  EXPECT_EQ(sequence_of(sample), sequence);
  EXPECT_EQ(field_of(*sample, 0), static_cast<std::uint32_t>(sequence));
}

TEST_F(Kill, RemovesTheSocketOfTheDead) {
  Process peer = start_peer({"attend"});
  ASSERT_EQ(peer.line(), "ready");
  EXPECT_EQ(names_in("/tmp", "sft_node").size(), 2U);
  peer.kill();
  EXPECT_TRUE(eventually([] { return names_in("/tmp", "sft_node").size() == 1; }));
}

/// Overwrites the longest list of free chunks in the management segment with invalid data.
void damage_free_list() {
  const std::string path = std::string("/dev/shm/") + iox::roudi::SHM_NAME;
  const std::size_t bytes = std::filesystem::file_size(path);
  const shm::Mapping mapping = shm::Mapping::open(iox::roudi::SHM_NAME, bytes, true, geteuid()).value();
  const std::span words(reinterpret_cast<std::uint32_t*>(mapping.bytes().data()), bytes / 4);
  std::size_t longest = 0, length = 0, end = 0;
  for (std::size_t i = 1; i < words.size(); ++i) {
    length = words[i] == words[i - 1] + 1 ? length + 1 : 0;
    if (length <= longest) continue;
    longest = length;
    end = i;
  }
  ASSERT_GT(longest, 1000U);
  words[end - 100] = 0xffffffff;
}

TEST_F(Kill, MakesTheDaemonStartAfreshOnceItIsIdleIfItsMemoryIsDamaged) {
  const core::HostToken token = node()->host_token();
  const pid_t daemon = daemon_pid();
  Process peer = start_peer({"publish", "1"});
  ASSERT_EQ(peer.line(), "publishing");
  damage_free_list();
  peer.kill();
  ASSERT_TRUE(eventually([] { return names_in("/tmp", "sft_node").size() == 1; }));
  leave();
  EXPECT_TRUE(eventually(
      [&] {
        const auto found = shm::HostMonitor::look({.everybody = true});
        return found.monitor && shm::host_token(found.monitor->file()) != token;
      },
      30s));
  EXPECT_EQ(daemon_pid(), daemon) << "the daemon must start afresh in the same process";
  Node next(no_daemon());
  EXPECT_TRUE(next.becomes_ready()) << next->description();
}

}  // namespace
}  // namespace sft::test
