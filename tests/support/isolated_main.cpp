// GoogleTest's main for tests that need a host of their own.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (GTEST_FLAG_GET(list_tests)) return RUN_ALL_TESTS();
  return sft::test::run_isolated([] {
    // If there is no isolation, the test at least uses another DDS domain than what else runs here.
    const std::string domain = std::to_string(100 + getpid() % 100);
    if (!sft::test::isolation_refusal().empty()) setenv("ROS_DOMAIN_ID", domain.c_str(), 1);
    return RUN_ALL_TESTS();
  });
}
