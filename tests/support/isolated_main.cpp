// GoogleTest's main for tests that need an isolated host.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (GTEST_FLAG_GET(list_tests)) return RUN_ALL_TESTS();
  return sft::test::run_isolated([] {
    // Without isolation the test at least uses a DDS domain that other programs here most likely do not use.
    const std::string domain = std::to_string(100 + getpid() % 100);
    if (!sft::test::isolation_refusal().empty()) setenv("ROS_DOMAIN_ID", domain.c_str(), 1);
    return RUN_ALL_TESTS();
  });
}
