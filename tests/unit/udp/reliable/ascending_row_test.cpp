#include "udp_transport/reliable/ascending_row.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

TEST(AscendingRowTest, CountsWhileSequencesAscendAndLastsSinceTheFirst) {
  AscendingRow row;
  row.add(5, test_start);
  row.add(9, test_start + 1ms);
  EXPECT_EQ(row.count(), 2U);
  EXPECT_EQ(row.lasts(test_start + 3ms), 3ms);
}

TEST(AscendingRowTest, BeginsAnewWithASequenceThatIsNotGreater) {
  AscendingRow row;
  row.add(5, test_start);
  row.add(9, test_start);
  row.add(9, test_start + 1ms);
  EXPECT_EQ(row.count(), 1U);
  EXPECT_EQ(row.lasts(test_start + 3ms), 2ms);
}

TEST(AscendingRowTest, BeginsAnewOnceItHasEnded) {
  AscendingRow row;
  row.add(5, test_start);
  row.end();
  row.add(9, test_start + 1ms);
  EXPECT_EQ(row.count(), 1U);
  EXPECT_EQ(row.lasts(test_start + 3ms), 2ms);
}

}  // namespace
}  // namespace sft::udp
