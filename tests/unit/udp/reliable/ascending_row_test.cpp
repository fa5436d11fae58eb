#include "udp_transport/reliable/ascending_row.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr AscendingRow::Time now{1h};

TEST(AscendingRowTest, CountsWhileSequencesAscendAndLastsSinceTheFirst) {
  AscendingRow row;
  row.add(5, now);
  row.add(9, now + 1ms);
  EXPECT_EQ(row.count(), 2U);
  EXPECT_EQ(row.lasts(now + 3ms), 3ms);
}

TEST(AscendingRowTest, BeginsAnewWithASequenceThatIsNotGreater) {
  AscendingRow row;
  row.add(5, now);
  row.add(9, now);
  row.add(9, now + 1ms);
  EXPECT_EQ(row.count(), 1U);
  EXPECT_EQ(row.lasts(now + 3ms), 2ms);
}

TEST(AscendingRowTest, BeginsAnewOnceItHasEnded) {
  AscendingRow row;
  row.add(5, now);
  row.end();
  row.add(9, now + 1ms);
  EXPECT_EQ(row.count(), 1U);
  EXPECT_EQ(row.lasts(now + 3ms), 2ms);
}

}  // namespace
}  // namespace sft::udp
