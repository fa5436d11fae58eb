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
  void cannot_be_reached(const std::string& why) { unreachable = {{7, why}}; }
  Serving serving() const { return negotiation.serving(100, unreachable); }
  PublisherStatus::Reader status() const { return serving().readers.at(0); }
  bool is_served_in_memory() const { return serving().memory.size() == 1; }

  Negotiation::Unreachable unreachable;
};

TEST_F(UnreachableReader, IsServedByUdpWithTheReason) {
  reader_comes();
  ASSERT_TRUE(is_served_in_memory());
  cannot_be_reached("its doorbell is gone");
  EXPECT_FALSE(is_served_in_memory());
  EXPECT_EQ(serving().network.size(), 1U);
  EXPECT_TRUE(status().served);
  EXPECT_EQ(status().transport, TransportKind::udp);
  EXPECT_EQ(status().reason, "its doorbell is gone");
  unreachable.clear();
  EXPECT_TRUE(is_served_in_memory()) << "once it can be reached";
}

TEST_F(UnreachableReader, IsKeptForTheWriterToAskForAgain) {
  reader_comes();
  cannot_be_reached("no descriptor is free");
  ASSERT_EQ(serving().unreached.size(), 1U);
  EXPECT_EQ(serving().unreached[0].reader, 7U);
  EXPECT_EQ(serving().unreached[0].destination, Locator(DoorbellAddress{7, 1}));
  EXPECT_TRUE(serving().memory_port) << "other readers may be reached";
}

TEST_F(UnreachableReader, WithoutUdpHasNoPathForAsLongAsThatLasts) {
  reader_comes(false);
  cannot_be_reached("its doorbell is gone");
  EXPECT_FALSE(status().served);
  EXPECT_TRUE(status().no_path);
  EXPECT_TRUE(status().no_path_yet);
  EXPECT_EQ(status().reason, "UDP is ruled out, and its doorbell is gone");
}

}  // namespace
}  // namespace sft::core
