// These tests do not run under the sanitizers, which reserve a very large address space.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "tests/system/opened_by_child.h"

namespace sft::test {
namespace {

using ::testing::AnyOf;

TEST(AddressSpace, AProgramWithTooLittleAddressSpaceGetsAnErrorThatSaysSo) {
  rlimit usual{};
  getrlimit(RLIMIT_AS, &usual);
  const auto page_bytes = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  std::size_t mapped = 0;
  std::ifstream("/proc/self/statm") >> mapped;
  const auto opened_with = [&](std::size_t mib) {
    return opened_by_child(
        [&] {
          const rlimit limit{mapped * page_bytes + (mib << 20), usual.rlim_max};
          setrlimit(RLIMIT_AS, &limit);
        },
        "RLIMIT_AS");
  };
  for (std::size_t mib = 0; mib <= 600; mib += 20) EXPECT_EQ(opened_with(mib), Opened::limit_exceeded) << mib;
  for (std::size_t mib = 620; mib <= 1200; mib += 20)
    EXPECT_THAT(opened_with(mib), AnyOf(Opened::limit_exceeded, Opened::node)) << mib;
  EXPECT_EQ(opened_with(2000), Opened::node);
}

}  // namespace
}  // namespace sft::test
