// The data that a process reads from other processes: the host file, the daemon's lock, and samples. Also the
// division of a budget of memory into pools.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "shm_transport/host/host_file.h"
#include "shm_transport/host/sample_check.h"
#include "shm_transport/host/socket_address.h"
#include "shm_transport/sftd/pools.h"
#include "tests/transports/shm/frame.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using namespace detail;

constexpr std::size_t MiB = 1 << 20;

TEST(HostFile, IsReadBackAsItWasWritten) {
  shm::HostFile file;
  for (std::size_t i = 0; i < file.token.size(); ++i) file.token[i] = static_cast<std::uint8_t>(i * 17);
  file.pid = 4711;
  file.port_pool_offset = 27'913'320;
  file.protocol = 7;
  file.segment = "robots";
  file.segment_id = 2;
  file.segment_bytes = 335'541'000;
  file.readers = 70'100;
  const auto read = shm::parse_host_file(shm::format(file));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->token, file.token);
  EXPECT_EQ(read->pid, file.pid);
  EXPECT_EQ(read->port_pool_offset, file.port_pool_offset);
  EXPECT_EQ(read->protocol, file.protocol);
  EXPECT_EQ(read->segment, file.segment);
  EXPECT_EQ(read->segment_id, file.segment_id);
  EXPECT_EQ(read->segment_bytes, file.segment_bytes);
  EXPECT_EQ(read->readers, file.readers);
}

TEST(HostFile, IsNotReadBeforeItsLastLineIsThere) {
  const std::string whole = shm::format({});
  for (std::size_t bytes = 0; bytes + 2 < whole.size(); ++bytes) {
    EXPECT_FALSE(shm::parse_host_file(whole.substr(0, bytes))) << bytes;
  }
}

TEST(HostFile, IsRefusedWithATokenThatIsTooLongOrWithoutAToken) {
  const std::string token = "000102030405060708090a0b0c0d0e0f";
  EXPECT_TRUE(shm::parse_host_file("token " + token + "\nend\n"));
  EXPECT_FALSE(shm::parse_host_file("token " + token + "0\nend\n"));
  EXPECT_FALSE(shm::parse_host_file("pid 1\nend\n"));
}

TEST(HostFile, IsRefusedIfANumberIsMalformedOrTooLarge) {
  const auto with_pid = [](const std::string& pid) {
    return shm::parse_host_file("token 000102030405060708090a0b0c0d0e0f\npid " + pid + "\nend\n");
  };
  EXPECT_TRUE(with_pid("12"));
  for (const char* bad : {"", "x", "12x", "12 ", "99999999999999999999"}) EXPECT_FALSE(with_pid(bad)) << bad;
}

TEST(RuntimeName, BeginsWithOurPrefixAndNamesNoOtherDirectory) {
  EXPECT_TRUE(shm::is_runtime_name("sft_node_1"));
  EXPECT_FALSE(shm::is_runtime_name("node_1"));
  EXPECT_FALSE(shm::is_runtime_name("sft_/../../etc/passwd"));
}

TEST(DaemonLockTest, TellsWhetherTheDaemonServesTheDevShmOfThisProcess) {
  struct stat memory {};
  if (stat("/dev/shm", &memory) != 0) GTEST_SKIP() << "/dev/shm cannot be used here";
  EXPECT_TRUE((shm::DaemonLock{.pid = 1, .shm_device = memory.st_dev}.serves_this_shm()));
  EXPECT_FALSE((shm::DaemonLock{.pid = 0, .shm_device = memory.st_dev}.serves_this_shm()));
  EXPECT_FALSE((shm::DaemonLock{.pid = 1, .shm_device = memory.st_dev + 1}.serves_this_shm()));
}

class FoundHost : public ShmTest {
 protected:
  static constexpr uid_t stranger = 65'534;
  using Finding = shm::HostWatch::Finding;
  static Finding found(const core::TrustedAccounts& accepted = {}) {
    return shm::HostWatch::look(accepted).finding;
  }
};

TEST_F(FoundHost, IsAliveAsLongAsItsFileIsLocked) {
  EXPECT_EQ(found(), Finding::absent);
  auto lock = shm::FileLock::take(shm::host_file_path);
  ASSERT_TRUE(lock) << lock.error().message;
  EXPECT_EQ(found(), Finding::starting);
  const std::string text = shm::format({});
  ASSERT_EQ(write(lock->descriptor(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  EXPECT_EQ(found(), Finding::alive);
  lock->unlock();
  EXPECT_EQ(found(), Finding::absent);
}

TEST_F(FoundHost, OfAnotherAccountIsForeignUnlessThatAccountIsAccepted) {
  const auto lock = shm::FileLock::take(shm::host_file_path);
  ASSERT_TRUE(lock) << lock.error().message;
  if (chown(shm::host_file_path, stranger, stranger) != 0) GTEST_SKIP() << "needs root, to give files away";
  EXPECT_EQ(found(), Finding::foreign);
  EXPECT_EQ(shm::HostWatch::look({}).user, stranger);
  EXPECT_EQ(found({.users = {stranger}}), Finding::starting);
}

TEST_F(FoundHost, HasALockThatIsReadOnlyWhileItIsHeld) {
  auto lock = shm::FileLock::take(shm::daemon_lock_path);
  ASSERT_TRUE(lock) << lock.error().message;
  const std::string text = shm::format_lock({.pid = 12, .shm_device = 34});
  ASSERT_EQ(write(lock->descriptor(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  const auto read = shm::read_daemon_lock();
  ASSERT_TRUE(read);
  EXPECT_EQ(read->pid, 12);
  EXPECT_EQ(read->shm_device, 34U);
  lock->unlock();
  EXPECT_FALSE(shm::read_daemon_lock());
}

TEST_F(FoundHost, HasASocketThatIsAliveOrGone) {
  const char* const path = "/tmp/sft_listener_test";
  EXPECT_EQ(shm::socket_state_at(path), shm::SocketState::gone);
  {
    const shm::Descriptor end(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const sockaddr_un address = shm::socket_address(path);
    ASSERT_EQ(bind(end.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(shm::socket_state_at(path), shm::SocketState::alive);
  }
  EXPECT_EQ(shm::socket_state_at(path), shm::SocketState::gone) << "nobody listens there any more";
  unlink(path);
}

TEST(HostFile, IsRefusedWithAShortToken) { EXPECT_FALSE(shm::parse_host_file("token 0011\nend\n")); }

TEST(HostFile, IsRefusedIfItNamesASegmentInAnotherDirectory) {
  shm::HostFile file;
  file.segment = "../etc/passwd";
  EXPECT_FALSE(shm::parse_host_file(shm::format(file)));
}

TEST(HostFile, MayHaveLinesOfLaterVersions) {
  EXPECT_TRUE(shm::parse_host_file("colour blue\ntoken 000102030405060708090a0b0c0d0e0f\nend\n"));
}

class SampleCheck : public ::testing::Test {
 protected:
  static constexpr core::EndpointId writer = 99;
  static constexpr std::uint32_t data = 40;

  SampleCheck() : memory_(frame_bytes(data) / 8 + 1) {
    sample_.data = reinterpret_cast<std::byte*>(memory_.data());
    new (sample_.data) SampleHeader{};
    write_frame(sample_, writer, 5, data);
  }
  bool accepts(std::size_t size = frame_bytes(data)) {
    return shm::check_sample(sample_.data, size, frame_type(), writer).has_value();
  }

  std::vector<std::uint64_t> memory_;
  core::SampleBuffer sample_;
};

TEST_F(SampleCheck, AcceptsAFrameAndReturnsItsExactSizeAndItsWriter) {
  const auto checked = shm::check_sample(sample_.data, 4096, frame_type(), writer);
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked->bytes, frame_bytes(data));
  EXPECT_EQ(checked->writer, writer);
  EXPECT_EQ(checked->sequence, 5U);
}

TEST_F(SampleCheck, RefusesAChunkThatIsNoSample) {
  sample_.header().magic ^= 1;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesAnotherType) {
  sample_.header().type_hash ^= 1;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesAnotherWriter) {
  sample_.header().writer ^= 1;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesABodyBeyondTheChunk) {
  EXPECT_FALSE(accepts(frame_bytes(data) - 1));
  sample_.header().body_bytes = 0xFFFF'FFFF;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesAnIndexOfAnotherSize) {
  sample_.header().slots = 4;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesABodyAtAnotherOffset) {
  sample_.header().body_offset -= 8;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesAnOffsetBehindTheBody) {
  for (std::uint32_t slot = 0; slot < 3; ++slot) {
    write_frame(sample_, writer, 5, data);
    ASSERT_TRUE(accepts());
    sample_.index()[slot] = data_offset + data;
    EXPECT_FALSE(accepts()) << slot;
    sample_.index()[slot] = data_offset + data - 1;
    EXPECT_TRUE(accepts()) << slot;
  }
}

TEST_F(SampleCheck, AcceptsASampleWithoutFieldsWhichHasNoBody) {
  for (std::uint32_t slot = 0; slot < 3; ++slot) sample_.index()[slot] = no_offset;
  sample_.header().body_bytes = 0;
  EXPECT_TRUE(accepts(frame_layout.body_offset));
  EXPECT_FALSE(accepts(frame_layout.body_offset - 1));
}

TEST_F(SampleCheck, RefusesAChunkWithoutRoomForTheHeader) {
  for (const std::size_t size : {std::size_t{0}, sizeof(SampleHeader) - 1, sizeof(SampleHeader)}) {
    EXPECT_FALSE(accepts(size)) << size;
  }
}

TEST(Pools, HoldSixteenMebibyteSamplesByDefault) {
  const auto plan = shm::plan_pools(320 * MiB);
  EXPECT_GE(plan.largest(), 16 * MiB + 4096);
  EXPECT_GE(plan.pools.back().count, 2U);
  EXPECT_TRUE(plan.remark.empty()) << plan.remark;
}

TEST(Pools, NeverExceedTheBudgetAndNeverWasteMuchOfIt) {
  for (std::size_t budget = 4 * MiB; budget < 2048 * MiB; budget += budget / 7) {
    const auto plan = shm::plan_pools(budget);
    EXPECT_LE(plan.bytes(), budget) << budget;
    EXPECT_GE(plan.bytes(), budget * 4 / 5) << budget;
  }
}

TEST(Pools, GrowWithTheBudget) {
  std::size_t largest = 0;
  for (std::size_t budget = 4 * MiB; budget < 1024 * MiB; budget += 4 * MiB) {
    const auto plan = shm::plan_pools(budget);
    EXPECT_GE(plan.largest(), largest) << budget;
    largest = plan.largest();
  }
}

TEST(Pools, AreInOrderOfSizeWithAtLeastTwoChunksEach) {
  for (const std::size_t budget : {4 * MiB, 30 * MiB, 100 * MiB, 320 * MiB}) {
    const auto plan = shm::plan_pools(budget);
    for (std::size_t i = 0; i < plan.pools.size(); ++i) {
      EXPECT_GE(plan.pools[i].count, 2U);
      EXPECT_EQ(plan.pools[i].bytes % 8, 0U);
      if (i > 0) {
        EXPECT_GT(plan.pools[i].bytes, plan.pools[i - 1].bytes);
      }
    }
  }
}

TEST(Pools, SayWhenLargeSamplesDoNotFit) {
  EXPECT_NE(shm::plan_pools(30 * MiB).remark.find("do not fit"), std::string::npos);
}

}  // namespace
}  // namespace sft::test
