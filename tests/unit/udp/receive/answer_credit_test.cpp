// These tests check the number of bytes that may be sent as answers to an unconfirmed address.
#include "udp_transport/receive/answer_credit.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

TEST(AnswerCreditTest, CoversThreeTimesWhatCameAndNotAByteMore) {
  AnswerCredit credit;
  EXPECT_FALSE(credit.covers(1));
  credit.received(100);
  EXPECT_TRUE(credit.covers(300));
  EXPECT_FALSE(credit.covers(301));
}

TEST(AnswerCreditTest, IsSpentByAnswers) {
  AnswerCredit credit;
  credit.received(100);
  credit.spend(200);
  EXPECT_TRUE(credit.covers(100));
  EXPECT_FALSE(credit.covers(101));
  credit.spend(1000);
  EXPECT_TRUE(credit.covers(0));
  EXPECT_FALSE(credit.covers(1)) << "it never turns over";
}

TEST(AnswerCreditTest, IsSavedUpToAMebibyteAndNoMore) {
  constexpr std::size_t mebibyte = 1 << 20;
  AnswerCredit credit;
  for (int i = 0; i < 1000; ++i) credit.received(8972);
  EXPECT_TRUE(credit.covers(mebibyte));
  EXPECT_FALSE(credit.covers(mebibyte + 1));
}

}  // namespace
}  // namespace sft::udp
