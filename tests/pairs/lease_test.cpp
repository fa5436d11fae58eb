// Rows "Crash, lease loss" and "Return" of negotiation.md: processes that are killed, stopped, or cut off
// from the network.
#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

class Leases : public NegotiationTest {
 protected:
  /// Starts a publisher and a recorded reader that reads only the height, so that the publisher sends no
  /// other field.
  void SetUp() override {
    NegotiationTest::SetUp();
    if (IsSkipped()) return;
    publisher_.emplace(here(), "publisher", with_short_lease());
    reader_.emplace(there(), "reader", with_short_lease());
    publisher().advertise();
    reader().subscribe("recorded");
    reader().read("height");
    publisher().start_publishing(2ms);
    ASSERT_TRUE(comes_true([&] {
      const json taken = taken_of(publisher(), reader());
      return !taken.is_null() && taken["last_mask"] == "height";
    }));
  }

  Peer& publisher() { return *publisher_; }
  Peer& reader() { return *reader_; }

  bool publisher_misses_reader() {
    return comes_true([&] {
      const json entry = reader_of(publisher(), reader());
      return !entry.is_null() && !entry["served"] && entry["reason"] == "its node does not answer";
    });
  }
  bool reader_misses_publisher() {
    return comes_true([&] {
      const json entry = writer_of(publisher(), reader());
      return !entry.is_null() && !entry["alive"];
    });
  }
  void expect_a_good_end(const std::string& mask) {
    publisher().stop_publishing();
    EXPECT_TRUE(agree(publisher(), reader()));
    // If the publisher was stopped for longer than the lease, Cyclone DDS may end the lease of the reader's
    // participant when the publisher continues, and discover the participant anew. The reader is served again
    // after that.
    EXPECT_TRUE(comes_true([&] { return is_served_with(publisher(), reader(), mask); }))
        << reader_of(publisher(), reader());
    EXPECT_TRUE(accounts_for_all(publisher(), reader()));
    EXPECT_EQ(taken_of(publisher(), reader())["last_mask"], mask);
  }

 private:
  std::optional<Peer> publisher_;
  std::optional<Peer> reader_;
};

TEST_F(Leases, AReaderThatIsStoppedLongerThanItsLeaseIsServedAgainWithTheSameMaskWhenItContinues) {
  reader().signal(SIGSTOP);
  EXPECT_TRUE(publisher_misses_reader());
  EXPECT_EQ(reader_of(publisher(), reader())["mask"], "height");
  reader().signal(SIGCONT);
  expect_a_good_end("height");
  EXPECT_EQ(taken_of(publisher(), reader())["masks"].size(), 2) << "all fields at first, then one";
}

TEST_F(Leases, AReaderThatIsStoppedForLessThanItsLeaseIsServedAllTheTime) {
  reader().signal(SIGSTOP);
  EXPECT_FALSE(comes_true([&] { return !is_served(publisher(), reader()); }, short_lease / 4));
  reader().signal(SIGCONT);
  expect_a_good_end("height");
  EXPECT_EQ(writer_of(publisher(), reader())["lost"], 0);
}

TEST_F(Leases, APublisherThatIsStoppedLongerThanItsLeaseIsHeardOnWhenItContinues) {
  publisher().signal(SIGSTOP);
  EXPECT_TRUE(reader_misses_publisher());
  EXPECT_TRUE(gets_event(reader(), "requested", "liveliness lost", "its node does not answer"));
  publisher().signal(SIGCONT);
  expect_a_good_end("height");
  EXPECT_TRUE(gets_event(reader(), "requested", "liveliness recovered"));
}

TEST_F(Leases, AReaderThatIsKilledIsServedNoMoreAndCostsOthersNothing) {
  Peer other(there(), "other");
  other.subscribe("data");
  ASSERT_TRUE(agree(publisher(), other));
  reader().kill_now();
  EXPECT_TRUE(publisher_misses_reader());
  EXPECT_TRUE(gets_event(publisher(), "offered", "unmatched", "its node does not answer"));
  publisher().stop_publishing();
  EXPECT_TRUE(agree(publisher(), other));
  EXPECT_TRUE(accounts_for_all(publisher(), other));
  EXPECT_EQ(writer_of(publisher(), other)["lost"], 0);
  EXPECT_EQ(taken_of(publisher(), other)["masks"].size(), 1);
}

TEST_F(Leases, APublisherThatIsKilledIsMissedAndCostsThoseWhoReadAnotherNothing) {
  Peer other(here(), "other");
  other.advertise();
  other.start_publishing(2ms);
  ASSERT_TRUE(agree(other, reader()));
  publisher().kill_now();
  EXPECT_TRUE(reader_misses_publisher());
  EXPECT_EQ(taken_of(publisher(), reader())["wrong"], 0);
  other.stop_publishing();
  EXPECT_TRUE(agree(other, reader()));
  EXPECT_TRUE(accounts_for_all(other, reader()));
  EXPECT_EQ(writer_of(other, reader())["lost"], 0);
}

TEST_F(Leases, APairWhoseCableIsPulledForLongIsJoinedAgainWithTheMaskThatWasAskedForMeanwhile) {
  there().set_plugged(false);
  EXPECT_TRUE(publisher_misses_reader());
  EXPECT_TRUE(reader_misses_publisher());
  reader().read("height, data");  // also reads from the last sample, which lacks the data
  there().set_plugged(true);
  expect_a_good_end("height, data");
  EXPECT_EQ(taken_of(publisher(), reader())["masks"].size(), 3);
}

TEST_F(Leases, AHostWhoseLinkIsDownForLongIsServedAgainWhenItIsUp) {
  there().set_link(false);
  EXPECT_TRUE(publisher_misses_reader());
  EXPECT_TRUE(reader_misses_publisher());
  there().set_link(true);
  expect_a_good_end("height");
}

TEST_F(Leases, APublishersHostWhoseLinkIsDownForLongServesAgainWhenItIsUp) {
  here().set_link(false);
  EXPECT_TRUE(publisher_misses_reader());
  EXPECT_TRUE(reader_misses_publisher());
  here().set_link(true);
  expect_a_good_end("height");
}

TEST_F(Leases, ALinkThatIsDownForAMomentCostsTheSamplesOfThatMomentAndNoRequest) {
  publisher().stop_publishing();
  for (Host* host : {&here(), &there()}) {
    ASSERT_TRUE(accounts_for_all(publisher(), reader()));
    const std::uint64_t lost = writer_of(publisher(), reader())["lost"];
    host->set_link(false);
    publisher().publish(100);
    reader().read("height, width");
    host->set_link(true);
    EXPECT_TRUE(accounts_for_all(publisher(), reader()));
    // The last samples may still be under way.
    EXPECT_GT(writer_of(publisher(), reader())["lost"], lost + 50);
  }
  EXPECT_FALSE(was_notified(publisher().status()["offered"], "unmatched"));
  expect_a_good_end("height, width");
}

/// A lost endpoint is removed after 60 s (Negotiation::forget_lost_after). This is the longest of all tests,
/// and it mostly waits.
TEST_F(Leases, APairThatIsCutOffForMoreThanAMinuteForgetsEachOtherAndBeginsAnewWhenItReturns) {
  const std::uint64_t requests = reader().status()["subscriber"]["requests"];
  there().set_plugged(false);
  publisher().stop_publishing();
  EXPECT_TRUE(publisher_misses_reader());
  EXPECT_TRUE(
      eventually([&] { return reader_of(publisher(), reader()).is_null(); }, 60s + hang_timeout, 100ms));
  EXPECT_TRUE(comes_true([&] { return writer_of(publisher(), reader()).is_null(); }));
  EXPECT_GT(reader().status()["subscriber"]["requests"], requests) << "it listens to the publisher no more";
  there().set_plugged(true);
  ASSERT_TRUE(agree(publisher(), reader()));
  publisher().publish(100);
  expect_a_good_end("height");
}

}  // namespace
}  // namespace sft::test
