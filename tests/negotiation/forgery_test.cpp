// A program on the network that withdraws what others announced, and asks in their name.
#include "tests/negotiation/fixture.h"

namespace sft::test {
namespace {

class Forgeries : public NegotiationTest {
 protected:
  /// Whether samples come again within a second and a half after the forger stops, on a machine that may be
  /// slow.
  bool flows(Peer& reader) {
    const std::uint64_t received = reader.status()["subscriber"]["received"];
    return comes_true([&] { return reader.status()["subscriber"]["received"] > received + 20; });
  }
};

TEST_F(Forgeries, APairWhoseEndpointsSomebodyElseWithdrawsWorksAgainAtOnce) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  Peer forger(there(), "forger");
  publisher.advertise();
  reader.subscribe("height, width");
  forger.forge("watch");
  ASSERT_TRUE(agree(publisher, reader));
  publisher.start_publishing();
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(flows(reader)) << i;
    forger.forge("withdraw");
  }
  EXPECT_TRUE(flows(reader));
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, reader));
}

TEST_F(Forgeries, AReaderInWhoseNameSomebodyElseAsksForNothingIsServedAgainAtOnce) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  Peer forger(there(), "forger");
  publisher.advertise();
  reader.subscribe("recorded");
  forger.forge("watch");
  ASSERT_TRUE(agree(publisher, reader));
  publisher.start_publishing();
  for (const std::uint64_t ahead : {std::uint64_t{1}, std::uint64_t{1000}, std::uint64_t{1} << 31,
                                    std::uint64_t{1} << 40, (std::uint64_t{1} << 63) - 1'000'000}) {
    ASSERT_TRUE(flows(reader)) << ahead;
    forger.forge("mute", ahead);
  }
  EXPECT_TRUE(flows(reader));
  reader.read("data");
  EXPECT_TRUE(comes_true([&] { return is_served_with(publisher, reader, "data"); }))
      << "what it asks for then counts";
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, reader));
}

}  // namespace
}  // namespace sft::test
