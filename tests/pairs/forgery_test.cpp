// A program on the network that withdraws what others announced, and asks in their name.
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

  /// A pair to whom samples come, and somebody who listens to what both say.
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

  /// Returns true if samples come again within a second and a half after the forger stops, on a machine that
  /// may be slow.
  bool flows(Peer& reader) {
    const std::uint64_t received = reader.status()["subscriber"]["received"];
    return comes_true([&] { return reader.status()["subscriber"]["received"] > received + 20; });
  }
  void expect_that_it_flows_for(std::chrono::seconds duration) {
    const auto end = std::chrono::steady_clock::now() + duration;
    while (std::chrono::steady_clock::now() < end) ASSERT_TRUE(flows(reader()));
  }
  /// True if an endpoint was told that another one did not answer, or had left.
  static bool missed_somebody(const json& status) {
    return was_told(status.at("offered"), "unmatched") || was_told(status.at("requested"), "unmatched");
  }
  /// By either of them: who makes its link anew hears the other one again, and speaks by a new writer, whose
  /// signs the other one believes.
  std::uint64_t links_renewed() { return links_renewed(publisher()) + links_renewed(reader()); }
  static std::uint64_t links_renewed(Peer& peer) { return peer.status()["node"]["links_renewed"]; }

 private:
  std::optional<Peer> publisher_, reader_, forger_;
};

TEST_F(Forgeries, APairWhoseEndpointsSomebodyElseWithdrawsWorksAgainAtOnce) {
  begin("height, width");
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(flows(reader())) << i;
    forger().forge("withdraw");
  }
  EXPECT_TRUE(flows(reader()));
}

TEST_F(Forgeries, AReaderInWhoseNameSomebodyElseAsksForNothingIsServedAgainAtOnce) {
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
}

TEST_F(Forgeries, AParticipantOfAnotherReleaseIsNamedOnceInTheLogOfEachNode) {
  begin("height, width");
  const auto lines = [](Peer& peer) {
    int count = 0;
    const json warnings = peer.status()["warnings"];
    for (const std::string line : warnings) {
      if (line.find("discovery: a participant with control protocol 7 is on eth0; this node has 14; they do "
                    "not see each other: use the same release") != std::string::npos)
        ++count;
    }
    return count;
  };
  EXPECT_EQ(lines(publisher()), 0);
  for (int i = 0; i < 3; ++i) {
    forger().forge("claim version", 7);
    EXPECT_TRUE(comes_true([&] { return lines(publisher()) == 1; })) << publisher().status()["warnings"];
    forger().forge("claim version", 13);
  }
  EXPECT_TRUE(flows(reader()));
  EXPECT_EQ(lines(publisher()), 1);
}

TEST_F(Forgeries, PulsesThatSomebodyMakesUpCostNoSampleAndFewLinks) {
  begin("height, width");
  const auto end = std::chrono::steady_clock::now() + 10s;
  while (std::chrono::steady_clock::now() < end) {
    forger().forge("pulses");
    ASSERT_TRUE(flows(reader()));
  }
  for (Peer* peer : {&publisher(), &reader()}) {
    EXPECT_LT(links_renewed(*peer), 12U) << "ever more seldom, on each of two links";
    EXPECT_FALSE(missed_somebody(peer->status())) << peer->status();
  }
}

TEST_F(Forgeries, AComplaintThatSomebodyMakesUpCostsNoSampleAndFewLinks) {
  begin("height, width");
  const auto end = std::chrono::steady_clock::now() + 8s;
  while (std::chrono::steady_clock::now() < end) {
    forger().forge("complain");
    ASSERT_TRUE(flows(reader()));
  }
  for (Peer* peer : {&publisher(), &reader()}) {
    const std::uint64_t renewed = links_renewed(*peer);
    EXPECT_GT(renewed, 0U) << "a complaint is heeded";
    EXPECT_LT(renewed, 12U) << "ever more seldom, on each of two links";
    EXPECT_FALSE(missed_somebody(peer->status())) << peer->status();
  }
}

/// Cyclone DDS takes all that a writer says for old once somebody has used a great sequence number in its
/// name.
class OutdatedByForgery : public Forgeries {
 protected:
  static constexpr auto two_leases = 13s;  // and what it takes to notice

  void SetUp() override {
    Forgeries::SetUp();
    if (!IsSkipped()) begin("height, width");
  }
};

TEST_F(OutdatedByForgery, SignsOfLifeAreHeardAgainBeforeAnyNodeIsTakenForDead) {
  // Cyclone does not believe it while it waits for what was said before the nodes met.
  const auto end = std::chrono::steady_clock::now() + two_leases;
  while (std::chrono::steady_clock::now() < end) {
    if (links_renewed() == 0) forger().forge("outdate signs of life");
    ASSERT_TRUE(flows(reader()));
  }
  EXPECT_GT(links_renewed(), 0U);
  for (Peer* peer : {&publisher(), &reader()})
    EXPECT_FALSE(missed_somebody(peer->status())) << peer->status();
}

TEST_F(OutdatedByForgery, AllNodesOfAProcessAreHeardAgain) {
  constexpr std::size_t neighbours = 3;
  const auto all_are_served = [&](Peer& peer) {
    const json status = peer.status();
    return std::ranges::all_of(status.at("neighbours"), [](const json& neighbour) {
      return neighbour.at("readers") == 2;  // its own, and that of the other process
    });
  };
  for (Peer* peer : {&publisher(), &reader()}) peer->open_neighbours(neighbours);
  for (Peer* peer : {&publisher(), &reader()})
    ASSERT_TRUE(comes_true([&] { return all_are_served(*peer); })) << peer->status();
  expect_that_it_flows_for(2s);  // in which each node says three times that it lives
  forger().forge("outdate signs of life");
  expect_that_it_flows_for(two_leases);
  EXPECT_GT(links_renewed(), 0U);
  for (Peer* peer : {&publisher(), &reader()}) {
    const json status = peer->status();
    EXPECT_TRUE(all_are_served(*peer)) << status;
    for (const json& neighbour : status.at("neighbours")) {
      EXPECT_EQ(neighbour.at("links_renewed"), status.at("node").at("links_renewed")) << "they share them";
      EXPECT_FALSE(missed_somebody(neighbour)) << neighbour;
    }
  }
}

TEST_F(OutdatedByForgery, AnnouncementsAndRequestsAreHeardAgain) {
  Peer late(there(), "late");
  late.subscribe("height, width");
  ASSERT_TRUE(agree(publisher(), late));
  // Cyclone does not believe the first ones, while it waits for what was said before the nodes met. Once it
  // does, nobody hears of a new subscriber.
  const auto is_heard_by_a_new_link = [&] {
    late.leave();
    forger().forge("outdate announcements");
    EXPECT_TRUE(flows(reader()));
    late.subscribe("recorded");
    late.read("height");
    EXPECT_TRUE(comes_true([&] { return is_served_with(publisher(), late, "height"); }))
        << reader_of(publisher(), late);
    return links_renewed(late) > 0;
  };
  EXPECT_TRUE(comes_true(is_heard_by_a_new_link));
  EXPECT_TRUE(flows(late));
  EXPECT_TRUE(flows(reader()));
  EXPECT_TRUE(agree(publisher(), late));
}

TEST_F(OutdatedByForgery, ARequestInAReadersOwnNameCountsNoLongerThanALinkTakesToBeMadeAnew) {
  reader().set_max_rate_hz(500);  // a request
  EXPECT_TRUE(comes_true([&] {
    forger().forge("ask for nothing");
    return !is_served(publisher(), reader());
  })) << "it is believed at first: nothing tells it from a true one";
  EXPECT_TRUE(comes_true([&] { return is_served_with(publisher(), reader(), "height, width"); }));
  EXPECT_GT(links_renewed(reader()), 0) << "the one in whose name it was";
  EXPECT_EQ(links_renewed(publisher()), 0);
  EXPECT_TRUE(flows(reader()));
}

}  // namespace
}  // namespace sft::test
