// The reconciler carries out the negotiation: it connects ports, and informs other nodes.
#include "tests/unit/core/node/reconciler_fixture.h"

namespace sft::core {
namespace {

using namespace detail;

TEST_F(ReconcilerTest, AReaderIsAnnouncedBeforeItListensToAnybody) {
  our_reader(200);
  ASSERT_EQ(discovery.announced.size(), 1U);
  EXPECT_THAT(discovery.announced[0].request.listening, IsEmpty());
  EXPECT_THAT(discovery.sent, IsEmpty());
}

TEST_F(ReconcilerTest, AReaderTakesDatagramsOfAWriterBeforeItSaysSo) {
  our_reader(200);
  writer_seen(7);
  EXPECT_THAT(connections.writers, ElementsAre(7));
  ASSERT_EQ(discovery.sent.size(), 1U);
  EXPECT_THAT(discovery.sent[0].listening, ElementsAre(7));
  EXPECT_EQ(discovery.sent[0].sequence, 2U);
}

// The writer may still exist, although its announcements do not reach this node. Then it must stop sending
// to this reader.
TEST_F(ReconcilerTest, AReaderSaysThatItListensNoMoreToAWriterThatWent) {
  our_reader(200);
  writer_seen(7);
  writer_seen(8);
  writer_departed(7);
  EXPECT_THAT(discovery.sent.back().listening, ElementsAre(8));
}

TEST_F(ReconcilerTest, WhatIsStillInFlightOfAWriterThatWentIsTaken) {
  our_reader(200);
  writer_seen(7);
  writer_departed(7);
  reconciler.tick();
  EXPECT_THAT(connections.writers, ElementsAre(7));
}

TEST_F(ReconcilerTest, AWriterThatWentIsDisconnectedOnceNothingOfItCanBeInFlightAnyMore) {
  our_reader(200);
  writer_seen(7);
  writer_seen(8);
  writer_departed(7);
  const Time went = std::chrono::steady_clock::now();
  reconciler.tick(went + AcceptedRequests::in_flight_max - std::chrono::seconds(1));
  EXPECT_THAT(connections.writers, ElementsAre(7, 8));
  reconciler.tick(went + AcceptedRequests::in_flight_max + std::chrono::milliseconds(1));
  EXPECT_THAT(connections.writers, ElementsAre(8));
}

TEST_F(ReconcilerTest, AWriterThatCameBackAtOnceIsListenedToForLong) {
  our_reader(200);
  writer_seen(7);
  writer_departed(7);
  writer_seen(7);
  reconciler.tick(std::chrono::steady_clock::now() + 2 * AcceptedRequests::in_flight_max);
  EXPECT_THAT(connections.writers, ElementsAre(7));
  EXPECT_THAT(discovery.sent.back().listening, ElementsAre(7));
}

TEST_F(ReconcilerTest, WhatAWriterThatIsHeardAnnouncesAnewReachesItsConnection) {
  our_reader(200);
  Endpoint first = endpoint(Role::writer, 7);
  first.max_sample_bytes = 1;
  first.waits = false;
  reconciler.take(std::make_shared<const Endpoint>(first));
  reconciler.reconcile();
  EXPECT_TRUE(connections.announced.empty());
  Endpoint second = first;
  second.max_sample_bytes = 1000;
  second.waits = true;
  reconciler.take(std::make_shared<const Endpoint>(second));
  reconciler.reconcile();
  ASSERT_EQ(connections.announced.size(), 1U);
  EXPECT_EQ(connections.announced[0].max_sample_bytes, 1000U);
  EXPECT_TRUE(connections.announced[0].waits);
  reconciler.take(EndpointLost{7});
  reconciler.reconcile();
  ASSERT_EQ(connections.announced.size(), 2U);
  EXPECT_FALSE(connections.announced[1].alive);
}

TEST_F(ReconcilerTest, AReaderWhoseProcessIsLostIsServedNoMoreUntilItIsSeenAgain) {
  const auto port = std::make_shared<TestWriterPort>();
  our_writer(7, port);
  Endpoint reader = endpoint(Role::reader, 200);
  reader.request.listening = {7};
  const auto is_served = [&] {
    reconciler.tick();
    return !port->routes.empty();
  };
  reconciler.take(std::make_shared<const Endpoint>(reader));
  EXPECT_TRUE(is_served());
  reconciler.take(EndpointLost{200});
  EXPECT_FALSE(is_served());
  reconciler.take(std::make_shared<const Endpoint>(reader));
  EXPECT_TRUE(is_served());
}

// Another writer may have the same short id until that writer is closed.
TEST_F(ReconcilerTest, AWriterThatCannotBeConnectedToIsToldOfOnceAndTriedAgainByItself) {
  connections.refusal = "the same short id";
  our_reader(200);
  writer_seen(7);
  writer_seen(8);
  for (int i = 0; i < 10; ++i) {
    reconciler.tick();
    writer_seen(7);
  }
  EXPECT_THAT(logged, ElementsAre("node: the same short id")) << "which both writers have";
  connections.refusal.clear();
  EXPECT_THAT(connections.writers, IsEmpty());
  EXPECT_TRUE(test::eventually([&] {
    reconciler.tick();
    return connections.writers.size() == 2;
  }));
}

// An example is a request that only lists one more writer from which the reader accepts datagrams.
TEST_F(ReconcilerTest, ARequestThatAsksAWriterForNothingElseIsShownAndChangesNothing) {
  const auto port = std::make_shared<TestWriterPort>();
  const auto core = our_writer(7, port);
  const Endpoint reader = endpoint(Role::reader, 200);
  reconciler.take(std::make_shared<const Endpoint>(reader));
  Request request = reader.request;
  request.sequence = 2;
  request.listening = {7};
  requested(request);
  EXPECT_EQ(port->routes.size(), 1U);
  const int changes = port->changes, reported = readers_changed;

  request.sequence = 3;
  request.listening = {7, 8};
  requested(request);
  EXPECT_EQ(port->changes, changes);
  EXPECT_EQ(readers_changed, reported);
  EXPECT_EQ(core->status().readers.at(0).request_sequence, 3U);

  request.sequence = 4;
  request.mask_words = type.full().to_words();
  requested(request);
  EXPECT_EQ(port->changes, changes + 1);
  EXPECT_EQ(readers_changed, reported + 1);
}

// While nothing happens, a program that receives events must not cause any work.
TEST_F(ReconcilerTest, StatesAreComparedForEventsOnlyWhereSomethingHasHappened) {
  const auto port = std::make_shared<TestWriterPort>();
  our_writer(7, port);
  const auto core = our_reader(200);
  writer_seen(8);
  reconciler.tick();
  const auto looks_of_ten_ticks = [&] {
    const int before = port->looks + connections.looks;
    for (int i = 0; i < 10; ++i) reconciler.tick();
    return port->looks + connections.looks - before;
  };
  EXPECT_EQ(looks_of_ten_ticks(), 0);
  for (const std::uint64_t sequence : {1U, 3U}) {
    connections.sample = BufferPool::make(1 << 20)->take(256);
    connections.sample->writer = 8;
    connections.sample->sequence = sequence;
    EXPECT_TRUE(core->take());
  }
  EXPECT_EQ(looks_of_ten_ticks(), 1) << "a sample was lost";
  writer_departed(8);
  EXPECT_EQ(looks_of_ten_ticks(), 0) << "that was told with its batch";
}

// Two threads may set the rate at the same time, and the notification of the first one may be posted last.
TEST_F(ReconcilerTest, TheMaximumRateThatWasSetLastIsAskedForInWhateverOrderTheNewsCome) {
  const auto core = our_reader(200);
  const auto asked = [&] { return discovery.sent.back().min_period_us; };
  ASSERT_TRUE(core->feed().set_max_rate_hz(10));
  ASSERT_TRUE(core->feed().set_max_rate_hz(20));
  reconciler.requirement_changed(200);
  EXPECT_EQ(asked(), 50'000U);
  reconciler.requirement_changed(200);
  EXPECT_EQ(asked(), 50'000U);
  EXPECT_EQ(discovery.sent.size(), 1U);
}

// If the port were destroyed earlier, it would wait for the callback, and so would the agent.
TEST_F(ReconcilerTest, ThePortOfAReaderThatGoesWithinItsCallbackGoesAfterIt) {
  std::shared_ptr<SubscriberCore> core;
  int ports_gone_within = 0;
  core = our_reader(200, [&](untyped::Sample&&) {
    core->close();
    reconciler.remove(200);
    reconciler.tick();
    ports_gone_within = connections.ports_gone;
  });
  connections.sample = BufferPool::make(1 << 20)->take(256);
  connections.sample->writer = 7;
  connections.sample->sequence = 1;
  core->arrived();
  EXPECT_EQ(ports_gone_within, 0);
  reconciler.tick();
  EXPECT_EQ(connections.ports_gone, 1);
}

// Until one tick after the history has left, samples must not be sent by another path, where they could
// overtake the datagrams under way.
TEST_F(ReconcilerTest, ALateReaderIsGivenTheHistoryATickAfterThatHasLeft) {
  const auto port = std::make_shared<TestWriterPort>();
  PublisherCore::Spec spec{7, "points", &type, 1 << 16};
  spec.qos.durability = transient_local;
  const auto core = std::make_shared<PublisherCore>(std::move(spec), BufferPool::make(1 << 20), port);
  Endpoint writer = endpoint(Role::writer, 7);
  writer.qos = {.durability = transient_local, .history_depth = 3};
  reconciler.add_writer(writer, core);
  Endpoint reader = endpoint(Role::reader, 200);
  reader.qos = writer.qos;
  reader.request.listening = reader.request.begun = {7};
  reconciler.take(std::make_shared<const Endpoint>(reader));
  reconciler.reconcile();
  const auto owed = [&] { return port->routes.at(0).history; };
  EXPECT_EQ(owed(), 3U);
  reconciler.tick();
  EXPECT_EQ(owed(), 3U) << "it is known to have left since now";
  port->history_left = false;
  reconciler.tick();
  port->history_left = true;
  reconciler.tick();
  EXPECT_EQ(owed(), 3U) << "more of it was sent meanwhile";
  reconciler.tick();
  EXPECT_EQ(owed(), 0U);
}

TEST_F(ReconcilerTest, AnAddressThatComesOrGoesIsAnnounced) {
  our_reader(200);
  reconciler.tick();
  EXPECT_EQ(discovery.announced.size(), 1U) << "nothing has changed";
  network.addresses_now.insert(network.addresses_now.begin(), {0x0b000001, 7000, 1 << 20});
  ASSERT_TRUE(test::eventually([&] {
    reconciler.tick();
    return discovery.announced.size() > 1;
  }));
  EXPECT_EQ(discovery.announced.back().addresses, network.addresses_now);
}

TEST_F(ReconcilerTest, AConnectionByWhichNothingArrivesIsSetUpAnewAndCounted) {
  const auto core = our_reader(200);
  Endpoint writer = endpoint(Role::writer, 7);
  writer.node_id = 66;
  writer.node = "camera";
  reconciler.take(std::make_shared<const Endpoint>(writer));
  reconciler.reconcile();
  ASSERT_THAT(discovery.sent.back().listening, ElementsAre(7));
  logged.clear();
  Time now = std::chrono::steady_clock::now() - std::chrono::minutes(1);
  std::uint64_t samples = 0;
  const std::size_t before = discovery.sent.size();
  for (int i = 0; i < 8 && discovery.sent.size() == before; ++i) {
    samples += 100;
    reconciler.take(NodeReport{.progress = {{7, samples, 0}}}, now += std::chrono::milliseconds(1000));
  }
  ASSERT_EQ(discovery.sent.size(), before + 1);
  EXPECT_THAT(discovery.sent.back().listening, IsEmpty());
  EXPECT_THAT(connections.writers, IsEmpty());
  EXPECT_EQ(core->feed().status().restarts, 1U);
  EXPECT_EQ(core->feed().status().writers.at(0).restarts, 1U);
  EXPECT_THAT(logged,
              ElementsAre("node: topic 'points', node 'camera': it sends, but nothing arrives by udp; the "
                          "connection is set up anew (restart 1)"));
  reconciler.tick();  // the pause is over by this tick
  EXPECT_THAT(connections.writers, ElementsAre(7));
  EXPECT_THAT(discovery.sent.back().listening, ElementsAre(7));
}

TEST_F(ReconcilerTest, WhatAWriterSentLastIsMissedAlsoIfItsNodeTellsNothingMore) {
  const auto core = our_reader(200);
  Endpoint writer = endpoint(Role::writer, 7);
  writer.node_id = 66;
  reconciler.take(std::make_shared<const Endpoint>(writer));
  reconciler.reconcile();
  Time now = std::chrono::steady_clock::now() - std::chrono::minutes(1);
  reconciler.take(NodeReport{.progress = {{7, 100, 0}}}, now);
  reconciler.take(NodeReport{.progress = {{7, 200, 0}}}, now += std::chrono::milliseconds(1000));
  for (int i = 0; i < 4; ++i) reconciler.tick(now += std::chrono::milliseconds(930));
  EXPECT_EQ(core->feed().status().restarts, 1U);
}

TEST_F(ReconcilerTest, AReaderThatHasGotNothingForTwoSecondsAsksForReportsOfItsTopic) {
  our_reader(200);
  writer_seen(7);
  Time now = std::chrono::steady_clock::now();
  const auto asks_after = [&](std::chrono::milliseconds duration) {
    for (const Time end = now + duration; now < end;) reconciler.tick(now += std::chrono::milliseconds(100));
    return discovery.inquired.contains({.topic = "points"});
  };
  EXPECT_FALSE(asks_after(std::chrono::milliseconds(1500)));
  EXPECT_TRUE(asks_after(std::chrono::milliseconds(2500)));
  writer_departed(7);
  EXPECT_FALSE(asks_after(std::chrono::milliseconds(1000)));
}

TEST_F(ReconcilerTest, AReaderThatAsksForALeaseAsksForReportsAtOnce) {
  const auto port = std::make_shared<TestReaderPort>(connections);
  auto core = std::make_shared<SubscriberCore>(SubscriberCore::Spec{.topic = "points",
                                                                    .type = &type,
                                                                    .feeds = {{.id = 200, .selection = mask}},
                                                                    .options = {},
                                                                    .callback = nullptr},
                                               bells->at(1), nullptr);
  core->ports().set_network(port);
  Endpoint reader = endpoint(Role::reader, 200);
  reader.qos.liveliness_lease = std::chrono::milliseconds(100);
  reconciler.add_reader(reader, {core, port});
  EXPECT_THAT(discovery.inquired, ElementsAre(Inquiry{.topic = "points"}));
}

/// A publisher of this node, with a reader on another node and a reader on this node.
class ReportsTest : public ReconcilerTest {
 protected:
  ReportsTest() {
    our_reader(300);
    Endpoint reader = endpoint(Role::reader, 200);
    reader.request.listening = {7};
    reconciler.take(std::make_shared<const Endpoint>(reader));
    reconciler.reconcile();
  }
  void others_ask(std::set<Inquiry> inquiries) {
    discovery.asked.all = std::move(inquiries);
    ++discovery.asked.made;
  }
  /// Returns the reports of `looks` ticks. A report is due at each tick.
  std::vector<NodeReport> reports_of(int looks = 1) {
    discovery.reports.clear();
    for (int i = 0; i < looks; ++i) reconciler.tick(now += std::chrono::milliseconds(930));
    return discovery.reports;
  }

  const std::shared_ptr<PublisherCore> writer = our_writer(7, std::make_shared<TestWriterPort>());
  const PointCloud2 cloud;
  Time now = std::chrono::steady_clock::now();
};

TEST_F(ReportsTest, TellTheProgressThreeTimesToThoseThatAsk) {
  writer->publish(&cloud);
  EXPECT_THAT(reports_of(3), IsEmpty()) << "no node has asked";
  others_ask({{.topic = "clouds"}});
  EXPECT_THAT(reports_of(3), IsEmpty());
  others_ask({{.topic = "points"}});
  const std::vector<NodeReport> reports = reports_of(10);
  ASSERT_EQ(reports.size(), 3U) << "two of them may get lost";
  ASSERT_EQ(reports[0].progress.size(), 1U);
  EXPECT_EQ(reports[0].progress[0].writer, 7U);
  EXPECT_EQ(reports[0].progress[0].samples, 1U);
  others_ask({{.topic = "points"}});
  EXPECT_EQ(reports_of(10).size(), 3U) << "another node has not heard it";
  writer->publish(&cloud);
  EXPECT_EQ(reports_of(10).size(), 3U);
  others_ask({Inquiry{}});
  EXPECT_EQ(reports_of(10).size(), 3U) << "of all topics";
}

TEST_F(ReportsTest, TellTheAccountsOfPairsToThoseThatAsk) {
  others_ask({{.topic = "points", .wants_accounts = true}});
  const std::vector<NodeReport> reports = reports_of(5);
  ASSERT_EQ(reports.size(), 5U) << "as long as others ask";
  const std::vector<Account>& accounts = reports[0].accounts;
  ASSERT_EQ(accounts.size(), 3U) << "of our publisher with two subscribers, and of ours with it";
  EXPECT_EQ(accounts[0].id, (AccountId{{7, 200}, Role::writer}));
  EXPECT_EQ(accounts[1].id, (AccountId{{7, 300}, Role::writer}));
  EXPECT_EQ(accounts[2].id, (AccountId{{7, 300}, Role::reader}));
  others_ask({});
  EXPECT_THAT(reports_of(3), IsEmpty());
}

TEST_F(ReportsTest, TellAccountsInTurnsIfThereAreMoreThanOneReportMayHave) {
  constexpr EndpointId first = 1000, end = 1050;
  for (EndpointId id = first; id < end; ++id) {
    Endpoint reader = endpoint(Role::reader, id);
    reader.request.listening = {7};
    reconciler.take(std::make_shared<const Endpoint>(reader));
  }
  others_ask({{.topic = "points", .wants_accounts = true}});
  std::set<AccountId> reported;
  for (const NodeReport& report : reports_of(2)) {
    EXPECT_LE(report.accounts.size(), accounts_max);
    for (const Account& account : report.accounts) reported.insert(account.id);
  }
  EXPECT_EQ(reported.size(), 3 + (end - first));
}

TEST_F(ReportsTest, AreForgottenOnceTheProgramAsksForNoneAnyMore) {
  Reports& ours = reconciler.reports();
  const auto is_known = [&] { return ours.accounts(now).at({7, 200}).subscriber.has_value(); };
  ours.ask("points");
  reconciler.take(NodeReport{.accounts = {{.id = {{7, 200}, Role::reader}}}}, now);
  EXPECT_TRUE(is_known());
  ours.ask_no_more("points");
  ours.ask("points");
  EXPECT_FALSE(is_known());
}

TEST_F(ReportsTest, AreAskedForOnTheTopicsThatTheProgramNamesUntilItTakesThatBackAsOften) {
  Reports& ours = reconciler.reports();
  ours.ask("points");
  ours.ask("points");
  const Inquiry accounts{.topic = "points", .wants_accounts = true};
  EXPECT_THAT(discovery.inquired, ElementsAre(accounts));
  ours.ask_no_more("points");
  reports_of();
  EXPECT_THAT(discovery.inquired, ElementsAre(accounts));
  ours.ask_no_more("points");
  reports_of();
  EXPECT_THAT(discovery.inquired, IsEmpty());
  ours.ask_for_progress(now);
  EXPECT_THAT(discovery.inquired, ElementsAre(Inquiry{}));
  now += std::chrono::seconds(11);
  writer_departed(9);
  reconciler.tick(now);
  EXPECT_FALSE(discovery.inquired.contains({}));
}

TEST_F(ReportsTest, OfAPairAreWhatBothSidesTell) {
  reconciler.reports().ask("points");
  reconciler.take(
      NodeReport{.accounts = {{.id = {{7, 200}, Role::reader}, .by_reader = {.received = 5, .lost = 6}}}},
      now);
  const auto known = [&](std::chrono::seconds after) {
    return reconciler.reports().accounts(now + after).at({7, 200});
  };
  const DomainSnapshot::Account pair = known(std::chrono::seconds(1));
  ASSERT_TRUE(pair.publisher);
  EXPECT_EQ(pair.publisher->age, std::chrono::seconds(0)) << "this node counts";
  ASSERT_TRUE(pair.subscriber);
  EXPECT_EQ(pair.subscriber->received, 5U);
  EXPECT_EQ(pair.subscriber->lost, 6U);
  EXPECT_EQ(pair.subscriber->age, std::chrono::seconds(1));
  EXPECT_EQ(known(std::chrono::seconds(10)).subscriber, std::nullopt);
}

TEST_F(ReportsTest, OfWhatIsNoPairOnATopicThatThisNodeAsksAboutCountForNothing) {
  const auto knows = [&](const PairId& pair) {
    reconciler.take(NodeReport{.accounts = {{.id = {pair, Role::reader}}}}, now);
    const PairAccounts accounts = reconciler.reports().accounts(now);
    const auto found = accounts.find(pair);
    return found != accounts.end() && found->second.subscriber;
  };
  EXPECT_FALSE(knows({7, 200})) << "this node has not asked";
  reconciler.reports().ask("points");
  Endpoint elsewhere = endpoint(Role::reader, 400);
  elsewhere.topic = "clouds";
  reconciler.take(std::make_shared<const Endpoint>(elsewhere));
  for (const PairId& pair : {PairId{7, 400}, PairId{200, 200}, PairId{7, 99}, PairId{0, 0}})
    EXPECT_FALSE(knows(pair));
  EXPECT_TRUE(knows({7, 200}));
}

}  // namespace
}  // namespace sft::core
