// Row "History": what a publisher retains for late readers.
#include "tests/negotiation/fixture.h"

namespace sft::test {
namespace {

const json retaining{{"transient_local", true}, {"history_depth", 5}};
const json asking{{"transient_local", true}};

class LateReaders : public NegotiationTest {};

TEST_F(LateReaders, OnAnotherHostGetWhatIsRetainedUnderTheirMaskAndThenWhatIsPublished) {
  Peer publisher(here(), "publisher");
  publisher.advertise(retaining);
  publisher.publish(20);
  Peer reader(there(), "reader");
  reader.subscribe("height, width", asking);
  ASSERT_TRUE(agree(publisher, reader));
  publisher.publish(50);
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(taken_of(publisher, reader)["first"], 16);
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
  EXPECT_EQ(taken_of(publisher, reader)["masks"].size(), 1);
}

TEST_F(LateReaders, OnTheSameHostGetWhatIsRetainedByUdpAndChangeOverToSharedMemoryThen) {
  const Daemon daemon(here());
  Peer publisher(here(), "publisher");
  Peer reader(here(), "reader");
  for (Peer* peer : {&publisher, &reader})
    ASSERT_TRUE(comes_true([&] { return peer->status()["node"]["shm_ready"]; }));
  publisher.advertise(retaining);
  publisher.publish(20);
  reader.subscribe("height, width", asking);
  ASSERT_TRUE(comes_true([&] { return is_served_by(publisher, reader, "shm"); }));
  ASSERT_TRUE(agree(publisher, reader));
  publisher.publish(50);
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  const json taken = taken_of(publisher, reader);
  EXPECT_EQ(taken["first"], 16);
  EXPECT_GE(taken["by_shm"], 50);
  EXPECT_LE(taken["by_shm"], taken["received"].get<int>() - 5);
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
}

TEST_F(LateReaders, ThatWereCutOffAndReturnAreNotGivenItAgain) {
  Peer publisher(here(), "publisher", with_short_lease());
  publisher.advertise(retaining);
  publisher.publish(20);
  Peer reader(there(), "reader", with_short_lease());
  reader.subscribe("height, width", asking);
  ASSERT_TRUE(agree(publisher, reader));
  ASSERT_TRUE(accounts_for_all(publisher, reader));
  there().set_plugged(false);
  ASSERT_TRUE(comes_true([&] { return !is_served(publisher, reader); }));
  publisher.publish(20);
  there().set_plugged(true);
  ASSERT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 20);
}

}  // namespace
}  // namespace sft::test
