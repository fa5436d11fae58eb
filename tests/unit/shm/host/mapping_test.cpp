// Mapping::contains() returns true for addresses in a segment. A reader calls it to check each address that
// another process wrote.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <string>

#include "shm_transport/host/mapping.h"

namespace sft::shm {
namespace {

constexpr std::size_t segment_bytes = 3 * 4096;

/// A file in /dev/shm. The destructor removes it.
class Segment {
 public:
  explicit Segment(std::size_t size) {
    const int file = shm_open(("/" + name_).c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    made_ = file >= 0 && ftruncate(file, static_cast<off_t>(size)) == 0;
    if (file >= 0) close(file);
  }
  ~Segment() { shm_unlink(("/" + name_).c_str()); }
  bool made() const { return made_; }
  const std::string& name() const { return name_; }

 private:
  const std::string name_ = "sft_mapping_test_" + std::to_string(getpid());
  bool made_ = false;
};

TEST(MappingTest, ContainsTheBytesInItAndNoneBeyondItsEnd) {
  const Segment segment(segment_bytes);
  if (!segment.made()) GTEST_SKIP() << "/dev/shm cannot be used here";
  const auto mapping = Mapping::open(segment.name(), segment_bytes, false, geteuid());
  ASSERT_TRUE(mapping) << mapping.error().message;
  const std::byte* const begin = mapping->bytes().data();
  EXPECT_TRUE(mapping->contains(begin, segment_bytes));
  EXPECT_TRUE(mapping->contains(begin + segment_bytes - 1, 1));
  EXPECT_TRUE(mapping->contains(begin + segment_bytes, 0));
  EXPECT_FALSE(mapping->contains(begin, segment_bytes + 1));
  EXPECT_FALSE(mapping->contains(begin + 1, segment_bytes));
  EXPECT_FALSE(mapping->contains(begin + segment_bytes, 1));
  EXPECT_FALSE(mapping->contains(begin + segment_bytes + 1, 0));
  EXPECT_FALSE(mapping->contains(begin - 1, 1));
  EXPECT_FALSE(mapping->contains(begin + 100, SIZE_MAX)) << "the sum of address and size overflows";
}

TEST(MappingTest, AFileThatIsShorterThanAnnouncedIsAnErrorThatNamesTheFile) {
  const Segment segment(segment_bytes - 1);
  if (!segment.made()) GTEST_SKIP() << "/dev/shm cannot be used here";
  const auto mapping = Mapping::open(segment.name(), segment_bytes, false, geteuid());
  ASSERT_FALSE(mapping);
  EXPECT_EQ(mapping.error().code, Errc::malformed);
  EXPECT_NE(mapping.error().message.find(segment.name()), std::string::npos);
}

}  // namespace
}  // namespace sft::shm
