// Readers that are attached in shared memory but cannot be woken there are served by another path, and the
// reason is reported.
#include "tests/unit/core/negotiation/negotiation_fixture.h"

namespace sft::core {
namespace {

class UnreachableReader : public NegotiationTest {
 protected:
  UnreachableReader() {
    at_host(token(2));
    our_writer();
  }
  void reader_comes(bool may_use_network = true) {
    Endpoint reader = endpoint(Role::reader, 7, here);
    reader.may_use_network = may_use_network;
    if (!may_use_network) reader.addresses.clear();
    negotiation.endpoint_seen(reader);
    negotiation.request_received(request(7, 2, F::height, {100}));
  }
  PublisherStatus::Reader status() const { return negotiation.serving(100).readers.at(0); }
  bool is_served_in_memory() const { return negotiation.serving(100).memory.size() == 1; }
};

TEST_F(UnreachableReader, IsServedByUdpWithTheReason) {
  reader_comes();
  ASSERT_TRUE(is_served_in_memory());
  EXPECT_TRUE(negotiation.reach_changed(100, 7, "its doorbell is gone"));
  EXPECT_FALSE(is_served_in_memory());
  EXPECT_EQ(negotiation.serving(100).network.size(), 1U);
  EXPECT_TRUE(status().served);
  EXPECT_EQ(status().transport, TransportKind::udp);
  EXPECT_EQ(status().reason, "its doorbell is gone");
}

TEST_F(UnreachableReader, ReturnsToSharedMemoryOnceItCanBeReached) {
  reader_comes();
  negotiation.reach_changed(100, 7, "no descriptor is free");
  EXPECT_TRUE(negotiation.reach_changed(100, 7, {}));
  EXPECT_TRUE(is_served_in_memory());
  EXPECT_FALSE(negotiation.reach_changed(100, 7, {})) << "that is no news";
}

TEST_F(UnreachableReader, IsKeptForTheWriterToAskForAgain) {
  reader_comes();
  negotiation.reach_changed(100, 7, "no descriptor is free");
  const Serving serving = negotiation.serving(100);
  ASSERT_EQ(serving.unreached.size(), 1U);
  EXPECT_EQ(serving.unreached[0].reader, 7U);
  EXPECT_EQ(serving.unreached[0].destination, Locator(DoorbellAddress{7, 1}));
  EXPECT_TRUE(serving.memory_port) << "other readers may be reached";
}

TEST_F(UnreachableReader, WithoutUdpHasNoPathForAsLongAsThatLasts) {
  reader_comes(false);
  negotiation.reach_changed(100, 7, "its doorbell is gone");
  EXPECT_FALSE(status().served);
  EXPECT_TRUE(status().no_path);
  EXPECT_TRUE(status().no_path_yet);
  EXPECT_EQ(status().reason, "UDP is ruled out, and its doorbell is gone");
}

TEST_F(UnreachableReader, ThatComesBackLaterIsBelievedToBeReachable) {
  reader_comes();
  negotiation.reach_changed(100, 7, "its doorbell is gone");
  negotiation.endpoint_departed(7);
  reader_comes();
  EXPECT_TRUE(is_served_in_memory());
}

TEST_F(UnreachableReader, OfAnotherWriterIsNoneOfThisOne) {
  reader_comes();
  negotiation.local_added(endpoint(Role::writer, 101), type);
  EXPECT_TRUE(negotiation.reach_changed(101, 7, "its doorbell is gone"));
  EXPECT_TRUE(is_served_in_memory());
  EXPECT_FALSE(negotiation.reach_changed(999, 7, "there is no such writer"));
}

}  // namespace
}  // namespace sft::core
