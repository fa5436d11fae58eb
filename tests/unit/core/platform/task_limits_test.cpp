// Files of the system say how many threads can still be started. In these tests directories replace /proc
// and /sys.
#include "core/platform/task_limits.h"

#include <gtest/gtest.h>

#include "tests/support/temporary_directory.h"

namespace sft::core {
namespace {

class TaskLimitsTest : public ::testing::Test {
 protected:
  TaskLimitsTest() {
    root.write("proc/loadavg", "0.12 0.34 0.56 3/1000 4227\n");
    root.write("proc/sys/kernel/threads-max", "192700\n");
    root.write("proc/sys/kernel/pid_max", "32768\n");
    root.write("proc/self/cgroup", "0::/user.slice/app.service\n");
    root.write("sys/fs/cgroup/user.slice/app.service/pids.max", "max\n");
    root.write("sys/fs/cgroup/user.slice/pids.max", "max\n");
  }

  std::optional<std::uint64_t> left(rlim_t of_user = RLIM_INFINITY) const {
    return threads_left(of_user, root.path());
  }

  test::TemporaryDirectory root;
};

TEST_F(TaskLimitsTest, TheSmallestLimitOfTheSystemCounts) {
  EXPECT_EQ(left(), 32768U - 1000U);
  root.write("proc/sys/kernel/threads-max", "2000\n");
  EXPECT_EQ(left(), 1000U);
}

TEST_F(TaskLimitsTest, TheLimitOfTheUserCountsAndAllThreadsOfTheSystemCountAsTheirs) {
  EXPECT_EQ(left(1500), 500U);
  EXPECT_EQ(left(1000), 0U);
  EXPECT_EQ(left(10), 0U);
}

TEST_F(TaskLimitsTest, TheLimitOfEveryControlGroupAboveCounts) {
  root.write("sys/fs/cgroup/user.slice/app.service/pids.max", "300\n");
  root.write("sys/fs/cgroup/user.slice/app.service/pids.current", "20\n");
  EXPECT_EQ(left(), 280U);
  root.write("sys/fs/cgroup/user.slice/pids.max", "400\n");
  root.write("sys/fs/cgroup/user.slice/pids.current", "390\n");
  EXPECT_EQ(left(), 10U);
  root.write("sys/fs/cgroup/user.slice/pids.current", "410\n");
  EXPECT_EQ(left(), 0U) << "it was lowered";
}

TEST_F(TaskLimitsTest, AControllerOfItsOwnGoesBeforeTheUnifiedHierarchy) {
  root.write("proc/self/cgroup", "8:pids:/app\n4:memory:/elsewhere\n0::/\n");
  root.write("sys/fs/cgroup/pids/app/pids.max", "100\n");
  root.write("sys/fs/cgroup/pids/app/pids.current", "7\n");
  EXPECT_EQ(left(), 93U);
}

TEST_F(TaskLimitsTest, WhereAFileCannotBeReadNothingIsKnown) {
  root.write("proc/self/cgroup", "0::/of/another/namespace\n");
  EXPECT_EQ(left(), std::nullopt);
  root.write("proc/self/cgroup", "0::/user.slice\n");
  EXPECT_NE(left(), std::nullopt);
  root.write("sys/fs/cgroup/user.slice/pids.max", "100\n");
  EXPECT_EQ(left(), std::nullopt) << "nobody knows how many there are";
  root.write("sys/fs/cgroup/user.slice/pids.current", "100\n");
  EXPECT_EQ(left(), 0U);
  root.write("proc/loadavg", "nonsense\n");
  EXPECT_EQ(left(), std::nullopt);
}

}  // namespace
}  // namespace sft::core
