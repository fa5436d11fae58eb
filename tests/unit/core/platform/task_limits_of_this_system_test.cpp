// Reads the files of the system on which the tests run. Some systems do not have these files.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/platform/task_limits.h"

namespace sft::core {
namespace {

TEST(TaskLimitsOfThisSystem, CanBeRead) {
  if (!std::filesystem::exists("/sys/fs/cgroup/cgroup.controllers") &&
      !std::filesystem::exists("/sys/fs/cgroup/pids"))
    GTEST_SKIP() << "no control groups are mounted below /sys/fs/cgroup";
  EXPECT_GT(threads_left(RLIM_INFINITY).value_or(0), 0U);
}

}  // namespace
}  // namespace sft::core
