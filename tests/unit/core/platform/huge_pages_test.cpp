// Files of the system say whether memory gets huge pages. In these tests a directory replaces /sys.
#include "core/platform/huge_pages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_directory.h"

namespace sft::core {
namespace {

using ::testing::HasSubstr;

class HugePagesTest : public ::testing::Test {
 protected:
  void system_says(const std::string& enabled, const std::string& page_bytes) {
    root.write("sys/kernel/mm/transparent_hugepage/enabled", enabled);
    root.write("sys/kernel/mm/transparent_hugepage/hpage_pmd_size", page_bytes);
  }
  std::string why_not() const { return why_no_huge_pages(root.path()); }

  test::TemporaryDirectory root;
};

TEST_F(HugePagesTest, AreUsedWhereTheSystemGivesThemToAllOrToThoseWhoAsk) {
  system_says("always [madvise] never\n", "2097152\n");
  EXPECT_EQ(why_not(), "");
  system_says("[always] madvise never\n", "2097152\n");
  EXPECT_EQ(why_not(), "");
}

TEST_F(HugePagesTest, AreNotUsedWhereTheSystemHasNoneOrTurnsThemOff) {
  EXPECT_THAT(why_not(), HasSubstr("the kernel has none"));
  system_says("always madvise [never]\n", "2097152\n");
  EXPECT_THAT(why_not(), HasSubstr("turns them off"));
}

TEST_F(HugePagesTest, AreNotUsedWhereOneIsLargerThanSamples) {
  system_says("always [madvise] never\n", "536870912\n");  // pages of 64 KiB, as some kernels for arm64 have
  EXPECT_THAT(why_not(), HasSubstr("512 MiB"));
}

}  // namespace
}  // namespace sft::core
