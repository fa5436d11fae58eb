#include "udp_transport/reliable/pending_ack.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

TEST(PendingAckTest, IsDueWhenWantedAndAfterSoManyBytesOrSamples) {
  PendingAck ack(1000);
  EXPECT_FALSE(ack.due());
  ack.want();
  EXPECT_TRUE(ack.due());
  ack.sent(1, 1);
  ack.came(999);
  EXPECT_FALSE(ack.due());
  ack.came(1);
  EXPECT_TRUE(ack.due());
  ack.sent(3, 3);
  for (std::size_t i = 1; i < PendingAck::acked_at_once; ++i) ack.came(0);
  EXPECT_FALSE(ack.due());
  ack.came(0);
  EXPECT_TRUE(ack.due());
}

TEST(PendingAckTest, IsDueWhenReadersTakeWhatTheLastOneDidNotTellOf) {
  PendingAck ack(1000);
  ack.sent(3, 5);
  ack.taken(3);
  EXPECT_FALSE(ack.due());
  ack.taken(4);
  EXPECT_TRUE(ack.due());
  ack.sent(5, 5);
  ack.taken(6);
  EXPECT_FALSE(ack.due()) << "the last one told of everything";
}

}  // namespace
}  // namespace sft::udp
