// The host file, the daemon's lock and the names of processes. The tests check that another process can read
// them.
#include "shm_transport/host/host_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>

namespace sft::test {
namespace {

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

TEST(HostFile, IsRefusedWithAShortToken) { EXPECT_FALSE(shm::parse_host_file("token 0011\nend\n")); }

TEST(HostFile, IsRefusedIfItNamesASegmentInAnotherDirectory) {
  shm::HostFile file;
  file.segment = "../etc/passwd";
  EXPECT_FALSE(shm::parse_host_file(shm::format(file)));
}

TEST(HostFile, MayHaveLinesOfLaterVersions) {
  EXPECT_TRUE(shm::parse_host_file("colour blue\ntoken 000102030405060708090a0b0c0d0e0f\nend\n"));
}

}  // namespace
}  // namespace sft::test
