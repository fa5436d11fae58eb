// These tests check the number of bytes that may be sent as answers to an unconfirmed address.
#include "udp_transport/receive/answer_path.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

TEST(AnswerPathTest, CoversThreeTimesWhatCameAndNotAByteMore) {
  AnswerPath path;
  EXPECT_FALSE(path.covers(1));
  path.received(100);
  EXPECT_TRUE(path.covers(300));
  EXPECT_FALSE(path.covers(301));
}

TEST(AnswerPathTest, IsUsedUpByAnswers) {
  const SocketAddress home{0x7F000001, 9};
  Ack ack;
  ack.missing_count = missing_max;
  AnswerPath path;
  path.turn_to(home);
  path.received(ack.bytes());
  std::size_t sent = 0;
  for (int i = 0; i < 5; ++i) {
    path.send(ack, [&](const SocketAddress& to, const Ack&) {
      EXPECT_EQ(to, home);
      ++sent;
    });
  }
  EXPECT_EQ(sent, 3U);
  EXPECT_TRUE(path.covers(0));
  EXPECT_FALSE(path.covers(1));
  EXPECT_EQ(path.parts_covered(), 0U);
}

TEST(AnswerPathTest, IsSavedUpToAMebibyteAndNoMore) {
  constexpr std::size_t mebibyte = 1 << 20;
  AnswerPath path;
  for (int i = 0; i < 1000; ++i) path.received(8972);
  EXPECT_TRUE(path.covers(mebibyte));
  EXPECT_FALSE(path.covers(mebibyte + 1));
}

}  // namespace
}  // namespace sft::udp
