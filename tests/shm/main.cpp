#include <gtest/gtest.h>

#include "isolated_host.h"

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (::testing::GTEST_FLAG(list_tests)) return RUN_ALL_TESTS();
  return sft::test::run_isolated([] { return RUN_ALL_TESTS(); });
}
