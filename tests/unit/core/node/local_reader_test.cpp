// Tests how a reader of a node uses its ports and makes its requests.
#include "core/node/local_reader.h"

#include <map>
#include <vector>

#include "tests/unit/core/node/local_endpoint_fixture.h"

namespace sft::core {
namespace {

class LocalReaderTest : public LocalEndpointTest {
 protected:
  void open(const Endpoint& endpoint, const std::shared_ptr<Recorder>& recorder = nullptr) {
    SubscriberCore::Spec spec{.topic = "points",
                              .type = &type,
                              .feeds = {{.id = endpoint.id, .selection = mask}},
                              .options = {},
                              .callback = nullptr};
    spec.options.on_event = [this](const Event& event) { events.push_back(event); };
    core = std::make_shared<SubscriberCore>(std::move(spec), bells->at(1), recorder);
    if (endpoint.may_use_network) core->ports().set_network(network_port);
    reader.emplace(node, endpoint,
                   LocalReader::Parts{core, endpoint.may_use_network ? network_port : nullptr});
    negotiation.local_added(endpoint, type);
  }
  void open_by_network() { open(over_network(Role::reader, 200)); }
  void open_in_memory() { open(here(Role::reader, 200)); }
  void seen(const Endpoint& writer) {
    negotiation.endpoint_seen(writer);
    reader->reconcile(unattached);
  }
  const Request& request() const { return negotiation.local(200)->request; }

  const std::unique_ptr<DoorbellPage> bells = DoorbellPage::create();
  Connections connections;
  const std::shared_ptr<TestReaderPort> network_port = std::make_shared<TestReaderPort>(connections);
  std::vector<Event> events;
  std::shared_ptr<SubscriberCore> core;
  std::optional<LocalReader> reader;
  std::size_t unattached = 0;
};

TEST_F(LocalReaderTest, ConnectsToTheWritersThatItShouldHearAndTellsThemOnceItDoes) {
  open_by_network();
  seen(over_network(Role::writer, 7));
  EXPECT_THAT(connections.writers, ElementsAre(7));
  EXPECT_THAT(request().listening, IsEmpty());
  EXPECT_TRUE(reader->look_after_connections().changed);
  EXPECT_THAT(request().listening, ElementsAre(7));
  EXPECT_THAT(discovery.sent.back().listening, ElementsAre(7));
  EXPECT_FALSE(reader->look_after_connections().changed);
}

TEST_F(LocalReaderTest, AConnectionThatFailsIsTriedAgainAfterAPause) {
  connections.refusal = "the same short id";
  open_by_network();
  seen(over_network(Role::writer, 7));
  reader->reconcile(unattached);
  EXPECT_THAT(logged, ElementsAre("node: the same short id"));
  EXPECT_FALSE(reader->may_try_again(std::chrono::steady_clock::now()));
  EXPECT_TRUE(reader->may_try_again(soon()));
}

TEST_F(LocalReaderTest, SamplesInFlightOfAWriterThatDepartedAreTakenForAWhile) {
  open_by_network();
  seen(over_network(Role::writer, 7));
  negotiation.endpoint_departed(7);
  reader->reconcile(unattached);
  reader->forget_what_was_in_flight(std::chrono::steady_clock::now());
  EXPECT_THAT(connections.writers, ElementsAre(7));
  reader->forget_what_was_in_flight(soon());
  EXPECT_THAT(connections.writers, IsEmpty());
}

TEST_F(LocalReaderTest, ConnectionsInMemoryAreCountedUntilTheirWritersShowUp) {
  memory.attaches = false;
  open_in_memory();
  seen(here(Role::writer, 7));
  EXPECT_EQ(unattached, 1U);
  EXPECT_EQ(reader->unattached(), 1U);
  EXPECT_TRUE(reader->look_after_connections().waiting);
  memory.attaches = true;
  EXPECT_EQ(reader->unattached(), 0U);
  EXPECT_FALSE(reader->look_after_connections().waiting);
  EXPECT_THAT(request().attached, ElementsAre(7));
}

TEST_F(LocalReaderTest, NoConnectionInMemoryIsMadeWhileTooManyWaitForTheirWriters) {
  open_in_memory();
  unattached = 128;
  seen(here(Role::writer, 7));
  EXPECT_THAT(memory.asked_for, IsEmpty());
  EXPECT_TRUE(reader->may_try_again(soon()));
}

TEST_F(LocalReaderTest, AfterItsPortWasDroppedItConnectsAnew) {
  open_in_memory();
  seen(here(Role::writer, 7));
  memory.connections.clear();
  reader->drop_memory();
  reader->reconcile(unattached);
  EXPECT_THAT(memory.connections, ElementsAre(7));
  EXPECT_THAT(memory.asked_for, ElementsAre(7, 7));
}

TEST_F(LocalReaderTest, WhatAFormerDaemonRefusedIsAskedOfTheNextOneAtOnce) {
  memory.refusal = Errc::limit_exceeded;
  open_in_memory();
  seen(here(Role::writer, 7));
  memory.refusal.reset();
  reader->reconcile(unattached);
  EXPECT_THAT(memory.connections, IsEmpty()) << "there is a pause";
  reader->drop_memory();
  reader->reconcile(unattached);
  EXPECT_THAT(memory.connections, ElementsAre(7));
}

TEST_F(LocalReaderTest, ItsLostPortStaysWhileSamplesWaitInItButNotForLong) {
  open_in_memory();
  seen(here(Role::writer, 7));
  memory.samples_wait = true;
  reader->drop_memory();
  reader->forget_what_was_in_flight(std::chrono::steady_clock::now());
  EXPECT_EQ(memory.readers, 1);
  reader->forget_what_was_in_flight(soon());
  EXPECT_EQ(memory.readers, 0) << "the next daemon needs the memory";

  reader->reconcile(unattached);
  memory.samples_wait = false;
  reader->drop_memory();
  reader->forget_what_was_in_flight(std::chrono::steady_clock::now());
  EXPECT_EQ(memory.readers, 0) << "nothing waits";

  reader->reconcile(unattached);
  memory.samples_wait = true;
  reader->drop_memory();
  EXPECT_EQ(memory.readers, 1);
  reader->close();
  EXPECT_EQ(memory.readers, 0);
}

TEST_F(LocalReaderTest, AnotherMaximumRateIsAskedForOnce) {
  open_by_network();
  EXPECT_FALSE(reader->requirement_changed()) << "it is the same as before";
  ASSERT_TRUE(core->feed().set_max_rate_hz(10));
  EXPECT_TRUE(reader->requirement_changed());
  EXPECT_EQ(discovery.sent.back().min_period_us, 100'000U);
  EXPECT_FALSE(reader->requirement_changed());
  EXPECT_EQ(discovery.sent.size(), 1U);
}

TEST_F(LocalReaderTest, ItsRequestTellsTheSubscriberWhatIsInForce) {
  open_by_network();
  negotiation.requirement_changed(200, {mask, 1000});
  reader->send_request();
  EXPECT_EQ(core->feed().status().requests, request().sequence);
  EXPECT_EQ(core->feed().status().mask, mask);
}

TEST_F(LocalReaderTest, AConnectionByWhichNothingArrivesIsClosedAndMadeAnewAfterAPause) {
  open_by_network();
  seen(over_network(Role::writer, 7));
  reader->look_after_connections();
  Time now = std::chrono::steady_clock::now();
  std::uint64_t sent = 0;
  bool restarted = false;
  for (int i = 0; i < 8 && !restarted; ++i) {
    sent += 100;
    now += std::chrono::milliseconds(650);
    restarted = reader->restart_stalled({{7, sent, 0}}, false, now);
  }
  EXPECT_TRUE(restarted);
  EXPECT_THAT(connections.writers, IsEmpty());
  EXPECT_THAT(request().listening, IsEmpty());
  EXPECT_EQ(core->feed().status().restarts, 1U);
  EXPECT_TRUE(reader->may_try_again(now + std::chrono::seconds(1)));
}

TEST_F(LocalReaderTest, WhileACallbackHoldsUpWhatArrivesNoConnectionIsRestarted) {
  open_by_network();
  seen(over_network(Role::writer, 7));
  reader->look_after_connections();
  Time now = std::chrono::steady_clock::now();
  for (std::uint64_t i = 1; i <= 20; ++i)
    EXPECT_FALSE(reader->restart_stalled({{7, i * 100, 0}}, true, now += std::chrono::milliseconds(650)));
  EXPECT_THAT(connections.writers, ElementsAre(7));
}

TEST_F(LocalReaderTest, DeadlinesOfAWriterAreWatchedOnlyAsLongAsItMatches) {
  Endpoint ours = over_network(Role::reader, 200);
  ours.qos.deadline = std::chrono::milliseconds(100);
  open(ours);
  Endpoint fits = over_network(Role::writer, 7);
  fits.qos.deadline = ours.qos.deadline;
  const auto missed = [&] { return core->feed().status().writers.at(0).deadlines_missed; };
  constexpr std::chrono::hours quiet{1};
  seen(fits);
  EXPECT_EQ(reader->pace(quiet), ours.qos.deadline / 2);
  reader->watch_promises(soon());
  const std::uint64_t first = missed();
  EXPECT_GE(first, 599U);
  Endpoint promises_nothing = fits;
  promises_nothing.qos.deadline = {};
  seen(promises_nothing);
  EXPECT_EQ(reader->pace(quiet), quiet);
  reader->watch_promises(soon() + quiet);
  EXPECT_EQ(missed(), first);
  seen(fits);
  reader->watch_promises(std::chrono::steady_clock::now());
  EXPECT_EQ(missed(), first) << "it begins anew";
  reader->watch_promises(soon());
  EXPECT_GT(missed(), first);
}

TEST_F(LocalReaderTest, ThatAWriterIsSilentIsToldAlsoIfTheNextOneLives) {
  Endpoint ours = over_network(Role::reader, 200);
  ours.qos.liveliness_lease = std::chrono::hours(1);
  open(ours);
  for (const auto& [id, lease] : std::map<EndpointId, int>{{7, 1}, {8, 3600}}) {
    Endpoint writer = over_network(Role::writer, id);
    writer.qos.liveliness_lease = std::chrono::seconds(lease);
    seen(writer);
  }
  reader->report_events();
  events.clear();
  reader->watch_promises(soon());
  reader->report_events();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].kind, Event::Kind::liveliness_lost);
  EXPECT_EQ(events[0].peer, 7U);
}

TEST_F(LocalReaderTest, ThatTheProgramHoldsTooManySamplesIsToldWithTheNextLookAndOnce) {
  open_in_memory();
  seen(here(Role::writer, 7));
  reader->report_events();
  events.clear();
  for (const std::uint64_t held_too_many : {2, 5}) {
    memory.held_too_many = held_too_many;
    for (int look = 0; look < 3; ++look) reader->report_events();
  }
  ASSERT_EQ(events.size(), 2U);
  for (const Event& event : events) EXPECT_EQ(event.kind, Event::Kind::held_too_many);
  EXPECT_EQ(events[0].count, 2U);
  EXPECT_EQ(events[1].count, 3U);
}

TEST_F(LocalReaderTest, HasAnAccountOfEachWriterThatMatches) {
  open_by_network();
  seen(over_network(Role::writer, 7));
  Endpoint other = over_network(Role::writer, 8);
  other.type_hash = 1;
  seen(other);
  EXPECT_THAT(reader->matching_writers(), ElementsAre(7));
}

TEST_F(LocalReaderTest, OnceItIsClosedItTakesNothingMore) {
  open_by_network();
  connections.sample = BufferPool::make(1 << 20)->take(256);
  connections.sample->sequence = 1;
  reader->close();
  EXPECT_FALSE(core->take());
}

}  // namespace
}  // namespace sft::core
