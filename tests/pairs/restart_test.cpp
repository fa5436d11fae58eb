// Rows "Reader restarts" and "Publisher restarts" of negotiation.md: processes that are killed and started
// again.
#include <memory>

#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

class Restarts : public NegotiationTest {
 protected:
  /// Starts a peer. All peers use one port, so that datagrams for a killed peer arrive at its successor.
  std::unique_ptr<Peer> start(const Host& host, const std::string& name) {
    return std::make_unique<Peer>(host, name, with_short_lease(at_one_port));
  }

  const json at_one_port{{"port", 17'000}};
};

TEST_F(Restarts, AReaderThatIsKilledAndStartedAnewGetsNothingOfTheMaskOfTheOneBefore) {
  const auto publisher = start(here(), "publisher");
  publisher->advertise();
  // Has the default lease, so that the lease lasts until the successor is served.
  Peer before(there(), "before", at_one_port);
  before.subscribe("*");
  publisher->start_publishing();
  ASSERT_TRUE(agree(*publisher, before));
  before.kill_now();
  const auto after = start(there(), "after");
  after->subscribe("height, width");
  ASSERT_TRUE(agree(*publisher, *after));
  EXPECT_TRUE(is_served_with(*publisher, before, "*")) << "too late to see anything";
  EXPECT_TRUE(comes_true([&] { return !is_served(*publisher, before); }));
  publisher->stop_publishing();
  EXPECT_TRUE(agree(*publisher, *after));
  EXPECT_TRUE(accounts_for_all(*publisher, *after));
  EXPECT_EQ(writer_of(*publisher, *after)["lost"], 0);
  EXPECT_EQ(taken_of(*publisher, *after)["masks"].size(), 1) << taken_of(*publisher, *after);
}

TEST_F(Restarts, ASuccessorWithTheSameMaskMissesNothingWhenTheLeaseOfTheKilledReaderEnds) {
  const auto publisher = start(here(), "publisher");
  publisher->advertise();
  const auto before = start(there(), "before");
  before->subscribe("data");
  publisher->start_publishing();
  ASSERT_TRUE(agree(*publisher, *before));
  before->kill_now();
  const auto after = start(there(), "after");
  after->subscribe("data");
  ASSERT_TRUE(agree(*publisher, *after));
  EXPECT_TRUE(is_served(*publisher, *before)) << "too late to see anything";
  EXPECT_TRUE(comes_true([&] { return !is_served(*publisher, *before); }));
  publisher->stop_publishing();
  EXPECT_TRUE(accounts_for_all(*publisher, *after));
  EXPECT_EQ(writer_of(*publisher, *after)["lost"], 0) << taken_of(*publisher, *after);
}

TEST_F(Restarts, AReaderWithTheMaskOfTheOneBeforeTakesEachSampleOnce) {
  const auto publisher = start(here(), "publisher");
  publisher->advertise();
  publisher->start_publishing();
  auto reader = start(there(), "reader_0");
  for (int i = 1; i <= 3; ++i) {
    reader->subscribe("data");
    ASSERT_TRUE(agree(*publisher, *reader));
    reader->kill_now();
    reader = start(there(), "reader_" + std::to_string(i));
  }
  reader->subscribe("data");
  ASSERT_TRUE(agree(*publisher, *reader));
  // Samples that were sent to the killed readers may have come first. What was published between these and
  // the reader's own samples counts as lost. All samples that are published from now on are its own.
  const std::uint64_t published = publisher->status()["publisher"]["published"];
  const auto comes_to = [&](std::uint64_t sequence) {
    return comes_true([&] {
      const json taken = taken_of(*publisher, *reader);
      return !taken.is_null() && taken["last"].get<std::uint64_t>() >= sequence;
    });
  };
  ASSERT_TRUE(comes_to(published + 1));
  const json lost = writer_of(*publisher, *reader)["lost"];
  ASSERT_TRUE(comes_to(published + 50));
  publisher->stop_publishing();
  EXPECT_TRUE(accounts_for_all(*publisher, *reader));
  EXPECT_EQ(writer_of(*publisher, *reader)["lost"], lost);
}

TEST_F(Restarts, APublisherThatIsKilledAndStartedAnewIsAnotherOneThatServesAtOnce) {
  const auto reader = start(there(), "reader");
  reader->subscribe("height, width");
  auto before = start(here(), "before");
  before->advertise();
  before->start_publishing();
  ASSERT_TRUE(comes_true([&] { return !taken_of(*before, *reader).is_null(); }));
  before->kill_now();
  const auto after = start(here(), "after");
  after->advertise();
  ASSERT_TRUE(agree(*after, *reader));
  after->publish(100);
  EXPECT_TRUE(accounts_for_all(*after, *reader));
  EXPECT_EQ(taken_of(*after, *reader)["first"], 1);
  EXPECT_EQ(writer_of(*after, *reader)["lost"], 0);
  EXPECT_TRUE(comes_true([&] { return !writer_of(*before, *reader)["alive"]; }));
  EXPECT_EQ(taken_of(*before, *reader)["wrong"], 0);
}

TEST_F(Restarts, OfEitherSideInAnyOrderTheNewPairAgreesAndAccountsForAll) {
  constexpr std::array masks{"*", "data", "header", "height, width"};
  auto publisher = start(here(), "publisher_0");
  auto reader = start(there(), "reader_0");
  publisher->advertise();
  reader->subscribe("data");
  for (int i = 1; i <= 8; ++i) {
    publisher->start_publishing();
    ASSERT_TRUE(agree(*publisher, *reader)) << "restart " << i;
    const std::string number = std::to_string(i);
    const bool of_publisher = random() % 2 == 0;
    auto& restarted = of_publisher ? publisher : reader;
    restarted->kill_now();
    restarted = start(of_publisher ? here() : there(), (of_publisher ? "publisher_" : "reader_") + number);
    of_publisher ? restarted->advertise() : restarted->subscribe(masks[random() % masks.size()]);
  }
  ASSERT_TRUE(agree(*publisher, *reader));
  publisher->stop_publishing();
  EXPECT_TRUE(accounts_for_all(*publisher, *reader));
}

}  // namespace
}  // namespace sft::test
