// A program on the network writes in the names of other participants: with Cyclone DDS alone, by heartbeats,
// and by RTPS datagrams. If a forgery cannot be distinguished from a true message, a link that is made anew
// repairs the effect.
#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

class Forgeries : public NegotiationTest {
 protected:
  void SetUp() override {
    NegotiationTest::SetUp();
    if (IsSkipped()) return;
    publisher_.emplace(here(), "publisher");
    reader_.emplace(there(), "reader");
    forger_.emplace(there(), "forger");
  }

  /// Starts a pair with samples under way, and a forger that receives the control messages of both peers.
  void begin(const std::string& fields) {
    publisher().advertise();
    reader().subscribe(fields);
    forger().forge("watch");
    ASSERT_TRUE(agree(publisher(), reader()));
    publisher().start_publishing();
    ASSERT_TRUE(flows(reader()));
  }

  void TearDown() override {
    if (!forger_) return;
    publisher().stop_publishing();
    EXPECT_TRUE(agree(publisher(), reader()));
  }

  Peer& publisher() { return *publisher_; }
  Peer& reader() { return *reader_; }
  Peer& forger() { return *forger_; }

  /// Waits until more than 20 further samples have arrived at the reader. Returns false if they do not
  /// arrive.
  bool flows(Peer& reader) {
    const std::uint64_t received = reader.status()["subscriber"]["received"];
    return comes_true([&] { return reader.status()["subscriber"]["received"] > received + 20; });
  }
  void expect_that_it_flows_for(std::chrono::seconds duration) {
    const auto end = std::chrono::steady_clock::now() + duration;
    while (std::chrono::steady_clock::now() < end) ASSERT_TRUE(flows(reader()));
  }
  /// Returns true if the status has an event that another endpoint did not answer or had left.
  static bool missed_a_peer(const json& status) {
    return was_notified(status.at("offered"), "unmatched") ||
           was_notified(status.at("requested"), "unmatched");
  }
  void expect_that_none_was_missed() {
    for (Peer* peer : {&publisher(), &reader()})
      EXPECT_FALSE(missed_a_peer(peer->status())) << peer->status();
  }
  /// Returns the number of links that either peer has made anew. A peer that makes its link anew receives the
  /// records of the other peer again.
  std::uint64_t links_renewed() { return links_renewed(publisher()) + links_renewed(reader()); }
  static std::uint64_t links_renewed(Peer& peer) { return peer.status()["node"]["links_renewed"]; }

 private:
  std::optional<Peer> publisher_, reader_, forger_;
};

TEST_F(Forgeries, RecordsThatAForgerDisposesOfAndWithdrawsHold) {
  begin("height, width");
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(flows(reader())) << i;
    forger().forge("withdraw");
  }
  EXPECT_TRUE(flows(reader()));
  expect_that_none_was_missed();
}

TEST_F(Forgeries, AnotherProcessThatAnnouncesAReaderAndAsksForNothingCountsForNothing) {
  begin("recorded");
  for (const std::uint64_t ahead : {std::uint64_t{1}, std::uint64_t{1000}, std::uint64_t{1} << 31,
                                    std::uint64_t{1} << 40, (std::uint64_t{1} << 63) - 1'000'000}) {
    ASSERT_TRUE(flows(reader())) << ahead;
    forger().forge("mute", ahead);
  }
  EXPECT_TRUE(flows(reader()));
  reader().read("data");
  EXPECT_TRUE(comes_true([&] { return is_served_with(publisher(), reader(), "data"); }))
      << "what it asks for then counts";
  expect_that_none_was_missed();
}

TEST_F(Forgeries, AParticipantThatNamesTheProcessOfAnotherOneCountsForNothing) {
  begin("recorded");
  // Longer than the time after which a participant is suspected.
  const auto end = std::chrono::steady_clock::now() + 8s;
  while (std::chrono::steady_clock::now() < end) {
    forger().forge("impersonate processes");
    ASSERT_TRUE(flows(reader()));
  }
  expect_that_none_was_missed();
  reader().read("height");
  EXPECT_TRUE(comes_true([&] { return is_served_with(publisher(), reader(), "height"); }));
}

TEST_F(Forgeries, AParticipantOfAnotherReleaseIsNamedOnceInTheLogOfEachNode) {
  begin("height, width");
  const auto lines = [](Peer& peer) {
    int count = 0;
    const json warnings = peer.status()["warnings"];
    for (const std::string line : warnings) {
      if (line.find("discovery: a participant with control protocol 7 is on eth0; this node has 16; they do "
                    "not see each other: use the same release") != std::string::npos)
        ++count;
    }
    return count;
  };
  EXPECT_EQ(lines(publisher()), 0);
  for (int i = 0; i < 3; ++i) {
    forger().forge("announce version", 7);
    EXPECT_TRUE(comes_true([&] { return lines(publisher()) == 1; })) << publisher().status()["warnings"];
    forger().forge("announce version", 14);
  }
  EXPECT_TRUE(flows(reader()));
  EXPECT_EQ(lines(publisher()), 1);
}

TEST_F(Forgeries, ForgedHeartbeatsCostNoSampleAndFewLinks) {
  begin("height, width");
  const auto end = std::chrono::steady_clock::now() + 10s;
  while (std::chrono::steady_clock::now() < end) {
    forger().forge("heartbeats");
    ASSERT_TRUE(flows(reader()));
  }
  for (Peer* peer : {&publisher(), &reader()})
    EXPECT_LT(links_renewed(*peer), 12U) << "ever more seldom, on each of two links";
  expect_that_none_was_missed();
}

/// After a great sequence number was used in the name of a writer, Cyclone DDS discards all later samples of
/// the true writer as old.
class OutdatedByForgery : public Forgeries {
 protected:
  void SetUp() override {
    Forgeries::SetUp();
    if (!IsSkipped()) begin("height, width");
  }

  /// Forges repeatedly, because Cyclone ignores forged numbers while it waits for samples that were written
  /// before the nodes met.
  void outdate_for(std::chrono::seconds duration) {
    const auto end = std::chrono::steady_clock::now() + duration;
    while (std::chrono::steady_clock::now() < end) {
      forger().forge("outdate announcements");
      ASSERT_TRUE(flows(reader()));
    }
  }
};

TEST_F(OutdatedByForgery, AllNodesOfAProcessAreHeardAgain) {
  constexpr std::size_t neighbours = 3;
  const auto all_are_served = [&](Peer& peer) {
    const json opened = peer.status().at("neighbours");
    return opened.size() == neighbours && std::ranges::all_of(opened, [](const json& neighbour) {
             // The neighbour's own reader, and that of the other process.
             return neighbour.at("readers") == 2;
           });
  };
  publisher().open_neighbours(neighbours);
  outdate_for(2s);
  reader().open_neighbours(neighbours);
  for (Peer* peer : {&publisher(), &reader()})
    EXPECT_TRUE(comes_true([&] { return all_are_served(*peer); })) << peer->status();
  EXPECT_GT(links_renewed(), 0U);
  EXPECT_TRUE(comes_true([&] {
    const json status = publisher().status();
    return std::ranges::all_of(status.at("neighbours"), [&](const json& neighbour) {
      return neighbour.at("links_renewed") == status.at("node").at("links_renewed");
    });
  })) << "nodes of a process share their links";
  for (Peer* peer : {&publisher(), &reader()}) {
    const json status = peer->status();
    for (const json& neighbour : status.at("neighbours")) EXPECT_FALSE(missed_a_peer(neighbour)) << neighbour;
  }
}

TEST_F(OutdatedByForgery, AnnouncementsAndRequestsAreHeardAgain) {
  Peer late(there(), "late");
  late.subscribe("height, width");
  ASSERT_TRUE(agree(publisher(), late));
  // After Cyclone has accepted a forged number, other nodes do not learn of a new subscriber.
  const auto is_heard_by_a_new_link = [&] {
    late.leave();
    forger().forge("outdate announcements");
    EXPECT_TRUE(flows(reader()));
    late.subscribe("recorded");
    late.read("height");
    EXPECT_TRUE(comes_true([&] { return is_served_with(publisher(), late, "height"); }))
        << reader_of(publisher(), late);
    return links_renewed() + links_renewed(late) > 0;
  };
  EXPECT_TRUE(comes_true(is_heard_by_a_new_link));
  EXPECT_TRUE(flows(late));
  EXPECT_TRUE(flows(reader()));
  EXPECT_TRUE(agree(publisher(), late));
}

TEST_F(OutdatedByForgery, ARequestInAReadersOwnNameCountsNoLongerThanALinkTakesToBeMadeAnew) {
  reader().set_max_rate_hz(500);  // makes the reader send a request
  EXPECT_TRUE(comes_true([&] {
    forger().forge("ask for nothing");
    return !is_served(publisher(), reader());
  })) << "it is believed at first: nothing tells it from a true one";
  EXPECT_TRUE(comes_true([&] { return is_served_with(publisher(), reader(), "height, width"); }));
  EXPECT_EQ(links_renewed(publisher()), 1U) << "it has found by two heartbeats that its copy differs";
  EXPECT_TRUE(flows(reader()));
}

}  // namespace
}  // namespace sft::test
