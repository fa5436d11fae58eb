// The files of the daemon's segments: their creation, and the behaviour of sftd if they cannot be created.
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <span>

#include "shm_transport/host/iceoryx.h"
#include "shm_transport/sftd/segment_file.h"
#include "tests/support/cleared_pages.h"
#include "tests/support/eventually.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

constexpr std::size_t mebibyte = std::size_t{1} << 20;

struct stat status_of(const std::string& path) {
  struct stat status {};
  EXPECT_EQ(stat(path.c_str(), &status), 0) << path;
  return status;
}

std::size_t bytes_in_memory(const std::string& path) {
  constexpr std::size_t block = 512;  // the unit of st_blocks in bytes, see stat(2)
  return static_cast<std::size_t>(status_of(path).st_blocks) * block;
}

class SegmentFile : public ShmTest {
 protected:
  void TearDown() override {
    std::filesystem::remove("/dev/shm/segment");
    ShmTest::TearDown();
  }
};

TEST_F(SegmentFile, HasAllItsMemoryFromTheBeginning) {
  ASSERT_TRUE(shm::make_segment_file("segment", 3 * mebibyte + 1));
  EXPECT_EQ(std::filesystem::file_size("/dev/shm/segment"), 3 * mebibyte + 1);
  EXPECT_GE(bytes_in_memory("/dev/shm/segment"), 3 * mebibyte + 1);
}

TEST_F(SegmentFile, IsForItsAccountAndItsGroupWhateverTheUmask) {
  const mode_t before = umask(077);
  const auto made = shm::make_segment_file("segment", mebibyte);
  umask(before);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(status_of("/dev/shm/segment").st_mode, mode_t{S_IFREG | 0660});
}

TEST_F(SegmentFile, TakesNoFileThatIsThereAlready) {
  std::ofstream("/dev/shm/segment") << "of another program";
  const auto made = shm::make_segment_file("segment", mebibyte);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Errc::address_in_use);
  EXPECT_EQ(made.error().message, "/dev/shm/segment could not be made: File exists");
  EXPECT_EQ(std::filesystem::file_size("/dev/shm/segment"), std::string("of another program").size());
}

TEST_F(SegmentFile, FollowsNoLink) {
  std::filesystem::create_symlink("/tmp/elsewhere", "/dev/shm/segment");
  EXPECT_FALSE(shm::make_segment_file("segment", mebibyte));
  EXPECT_FALSE(std::filesystem::exists("/tmp/elsewhere"));
}

TEST_F(SegmentFile, LeavesNothingWhereThereIsNoSpaceForIt) {
  const ShmOfSize small(2);
  const auto made = shm::make_segment_file("segment", 3 * mebibyte);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Errc::out_of_memory);
  EXPECT_EQ(made.error().message,
            "/dev/shm/segment could not be given 3145728 bytes: No space left on device");
  EXPECT_TRUE(std::filesystem::is_empty("/dev/shm"));
}

class SftdSegments : public ShmTest {};

TEST_F(SftdSegments, HaveAllTheirMemoryFromTheBeginning) {
  Process daemon({sftd_path(), "--foreground", "--log-level=warning"});
  ASSERT_EQ(daemon.line(), "sftd: ready");
  std::size_t segments = 0;
  for (const auto& file : std::filesystem::directory_iterator("/dev/shm")) {
    EXPECT_GE(bytes_in_memory(file.path()), file.file_size()) << file.path();
    segments += file.file_size() >= mebibyte ? 1 : 0;
  }
  EXPECT_EQ(segments, 2U);
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.exit_code(), 0);
}

/// Returns the number of KiB of the file that are mapped in the process ("Rss" in smaps, see proc(5)).
std::size_t mapped_kib(pid_t pid, const std::string& file) {
  std::ifstream mappings("/proc/" + std::to_string(pid) + "/smaps");
  std::size_t kib = 0;
  bool is_of_file = false;
  for (std::string line; std::getline(mappings, line);) {
    if (line.find("-") < line.find(" ")) is_of_file = line.ends_with(file);
    if (is_of_file && line.starts_with("Rss:")) kib += std::stoul(line.substr(4));
  }
  return kib;
}

// If the daemon mapped pages to clear them, its threads would block each other, for a long time on a busy
// machine.
TEST_F(SftdSegments, AreClearedWithoutAnybodyWhoUsesOrMapsThem) {
  Process daemon({sftd_path(), "--foreground", "--log-level=warning"});
  ASSERT_EQ(daemon.line(), "sftd: ready");
  std::size_t segments = 0, bytes = 0, mapped = 0;
  for (const auto& file : std::filesystem::directory_iterator("/dev/shm")) {
    if (file.file_size() < mebibyte) continue;
    ++segments;
    const core::FileDescriptor opened(open(file.path().c_str(), O_RDONLY | O_CLOEXEC));
    void* const mapping = mmap(nullptr, file.file_size(), PROT_READ, MAP_SHARED, opened.get(), 0);
    ASSERT_NE(mapping, MAP_FAILED);
    const std::span all(static_cast<const std::byte*>(mapping), file.file_size());
    EXPECT_TRUE(eventually([&] { return cleared_bytes(all) >= all.size(); })) << file.path();
    munmap(mapping, all.size());
    bytes += all.size();
    mapped += 1024 * mapped_kib(daemon.pid(), file.path());
  }
  EXPECT_EQ(segments, 2U);
  EXPECT_LT(mapped, bytes / 4);
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.exit_code(), 0);
}

std::size_t bytes_in_all_files() {
  std::size_t bytes = 0;
  for (const auto& file : std::filesystem::directory_iterator("/dev/shm"))
    bytes += bytes_in_memory(file.path());
  return bytes;
}

/// A daemon with memory for many large chunks. The daemon takes this memory only when chunks are used.
class ChunksOnDemand : public ShmNodeTest {
 protected:
  static constexpr std::uint32_t large_bytes = 30'000'000, common_bytes = 8'000'000;
  ChunksOnDemand() : ShmNodeTest(1900) {}
  void SetUp() override {
    ShmNodeTest::SetUp();
    if (IsSkipped()) return;
    writer_.emplace(node(), 1);
  }
  void TearDown() override {
    writer_.reset();
    ShmNodeTest::TearDown();
  }
  /// Fills /dev/shm until only `bytes` are free.
  static void leave_free(std::uint64_t bytes) {
    const core::FileDescriptor file(open(filler, O_RDWR | O_CREAT | O_CLOEXEC, 0600));
    const std::uint64_t free = std::filesystem::space("/dev/shm").free;
    ASSERT_EQ(posix_fallocate(file.get(), 0, static_cast<off_t>(free - bytes)), 0);
  }
  static constexpr const char* filler = "/dev/shm/filler";
  std::optional<Writer> writer_;
};

TEST_F(ChunksOnDemand, HaveNoMemoryBeforeTheyAreLent) {
  const std::size_t before = bytes_in_all_files();
  EXPECT_LT(before, 400 * mebibyte);
  const core::SampleHandle sample = writer_->loan(large_bytes);
  ASSERT_TRUE(sample);
  EXPECT_GE(bytes_in_all_files(), before + large_bytes - mebibyte) << "some pages were there before";
  EXPECT_LT(bytes_in_all_files(), before + large_bytes + 2 * mebibyte) << "the chunk is larger";
  EXPECT_EQ(writer_->send(sample, large_bytes), core::SendStatus::sent) << "all of it was written";
}

TEST_F(ChunksOnDemand, AreNotLentIfTheHostHasNoMemoryForThem) {
  leave_free(12 * mebibyte);
  const std::size_t before = bytes_in_all_files();
  EXPECT_FALSE(writer_->loan(large_bytes));
  EXPECT_LE(bytes_in_all_files(), before + mebibyte) << "nothing is kept of what was too little";
  EXPECT_TRUE(writer_->loan(common_bytes)) << "this one has its memory from the beginning";
  std::filesystem::remove(filler);
  EXPECT_TRUE(writer_->loan(large_bytes));
}

TEST_F(SftdSegments, AreAllRemovedIfOneOfThemCannotBeMade) {
  const ShmOfSize large(256);
  // Allows three files: the directory, the host file and the management segment. The segment of samples is
  // not allowed.
  ASSERT_EQ(mount(nullptr, "/dev/shm", nullptr, MS_REMOUNT, "nr_inodes=3"), 0);
  Process daemon({sftd_path()});
  const std::string output = daemon.all_output();
  EXPECT_TRUE(contains(output, "could not be made: No space left on device")) << output;
  EXPECT_FALSE(contains(output, iox::roudi::SHM_NAME)) << output;
  EXPECT_EQ(daemon.exit_code(), 1);
  EXPECT_TRUE(std::filesystem::is_empty("/dev/shm"));
  EXPECT_TRUE(std::filesystem::is_empty("/tmp"));
}

}  // namespace
}  // namespace sft::test
