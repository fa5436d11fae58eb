// Tests how a writer of a node uses its ports.
#include "core/node/local_writer.h"

#include <map>

#include "tests/support/eventually.h"
#include "tests/unit/core/node/local_endpoint_fixture.h"

namespace sft::core {
namespace {

class LocalWriterTest : public LocalEndpointTest {
 protected:
  void open(const Endpoint& endpoint) {
    PublisherCore::Spec spec{endpoint.id, "points", &type, 1 << 16};
    spec.qos = endpoint.qos;
    spec.on_event = [this](const Event& event) { events.push_back(event); };
    spec.asserted = [this] { ++notifications; };
    core = std::make_shared<PublisherCore>(std::move(spec), BufferPool::make(1 << 20),
                                           endpoint.may_use_network ? network_port : nullptr);
    writer.emplace(node, endpoint, core);
    negotiation.local_added(endpoint, type);
  }
  void open_in_memory() { open(here(Role::writer, 7)); }
  /// Makes a reader attach to the writer of this node in shared memory.
  void reader_attaches(EndpointId id) {
    Endpoint reader = here(Role::reader, id);
    reader.request.attached = {7};
    negotiation.endpoint_seen(reader);
    writer->reconcile();
  }
  /// Makes a reader on another host listen to the writer of this node.
  void reader_listens(EndpointId id) {
    Endpoint reader = over_network(Role::reader, id);
    reader.request.listening = {7};
    negotiation.endpoint_seen(reader);
    writer->reconcile();
  }
  /// Tries to open the port again after each pause. Returns true once the writer is served.
  bool is_served_in_the_end() {
    return test::eventually([&] {
      if (writer->may_try_again(std::chrono::steady_clock::now())) writer->reconcile();
      return !memory.routes.empty() && core->status().readers.at(0).served;
    });
  }
  std::vector<EndpointId> served_in_memory() const {
    std::vector<EndpointId> readers;
    for (const Route& route : memory.routes) readers.push_back(route.reader);
    return readers;
  }

  const std::shared_ptr<TestWriterPort> network_port = std::make_shared<TestWriterPort>();
  std::vector<Event> events;
  int notifications = 0;  ///< the number of times that the node's agent was notified of assertions
  std::shared_ptr<PublisherCore> core;
  std::optional<LocalWriter> writer;
};

TEST_F(LocalWriterTest, OpensItsPortInSharedMemoryOnceAReaderMayNeedIt) {
  open_in_memory();
  reader_attaches(200);
  EXPECT_EQ(memory.writers, 1);
  EXPECT_THAT(served_in_memory(), ElementsAre(200));
  writer->reconcile();
  EXPECT_EQ(memory.openings, 1);
}

TEST_F(LocalWriterTest, APortThatCannotBeOpenedIsNotTriedAgainAtOnceButAfterAPause) {
  memory.is_full = true;
  open_in_memory();
  reader_attaches(200);
  writer->reconcile();
  EXPECT_EQ(memory.openings, 1);
  EXPECT_THAT(logged, ElementsAre("node: no port is left"));
  EXPECT_FALSE(writer->may_try_again(std::chrono::steady_clock::now()));
  EXPECT_TRUE(writer->may_try_again(soon()));
}

// The daemon has made the port, so that the reader has attached to it, but the daemon has answered too late.
TEST_F(LocalWriterTest, AReaderThatIsAttachedIsNotServedInMemoryBeforeThePortIsOpen) {
  memory.is_full = true;
  open_in_memory();
  reader_attaches(200);
  ASSERT_EQ(core->status().readers.size(), 1U);
  EXPECT_FALSE(core->status().readers[0].served);
  EXPECT_EQ(core->status().readers[0].reason,
            "UDP is ruled out, and the publisher's port in shared memory is not open: no port is left");
  EXPECT_FALSE(writer->look_after_reach(soon())) << "it is in vain before the port is open";
  memory.is_full = false;
  EXPECT_TRUE(is_served_in_the_end());
  EXPECT_THAT(served_in_memory(), ElementsAre(200));
}

TEST_F(LocalWriterTest, AReaderThatAlsoListensIsServedByUdpUntilThePortIsOpen) {
  memory.is_full = true;
  Endpoint endpoint = over_network(Role::writer, 7);
  endpoint.may_use_memory = true;
  endpoint.host = memory.host_token();
  open(endpoint);
  Endpoint reader = endpoint;
  reader.id = 200;
  reader.role = Role::reader;
  reader.request.attached = {7};
  reader.request.listening = {7};
  negotiation.endpoint_seen(reader);
  writer->reconcile();
  EXPECT_EQ(core->status().readers.at(0).transport, TransportKind::udp);
  memory.is_full = false;
  EXPECT_TRUE(is_served_in_the_end());
  EXPECT_EQ(core->status().readers.at(0).transport, TransportKind::shm);
}

TEST_F(LocalWriterTest, AfterItsPortWasDroppedItIsServedAnewWithTheSameReaders) {
  open_in_memory();
  reader_attaches(200);
  memory.routes.clear();
  writer->drop_memory();
  writer->reconcile();
  EXPECT_EQ(memory.openings, 2);
  EXPECT_EQ(memory.writers, 1) << "the first port is gone";
  EXPECT_THAT(served_in_memory(), ElementsAre(200));
}

TEST_F(LocalWriterTest, AReaderThatCannotBeToldOfSamplesIsNotServedInMemoryUntilThatIsTriedAgain) {
  memory.why_unreachable = "its doorbell is gone";
  open_in_memory();
  reader_attaches(200);
  EXPECT_THAT(served_in_memory(), IsEmpty());
  EXPECT_THAT(logged, ElementsAre("node: points: the subscriber of node '' is not served in shared memory: "
                                  "its doorbell is gone"));
  memory.why_unreachable.clear();
  EXPECT_FALSE(writer->look_after_reach(std::chrono::steady_clock::now()));
  EXPECT_TRUE(writer->look_after_reach(soon()));
  writer->reconcile();
  EXPECT_THAT(served_in_memory(), ElementsAre(200));
}

TEST_F(LocalWriterTest, AReaderThatCouldNotBeToldOfSamplesIsTriedAtOnceWhenItAttachesAnew) {
  memory.why_unreachable = "its doorbell is gone";
  open_in_memory();
  reader_attaches(200);
  negotiation.endpoint_seen(here(Role::reader, 200));
  writer->reconcile();
  memory.why_unreachable.clear();
  reader_attaches(200);
  EXPECT_THAT(served_in_memory(), ElementsAre(200));
}

TEST_F(LocalWriterTest, ItsProgressIsTakenThreeTimesForAllThatWasSentAndOnlyIfAReaderIsServed) {
  open(over_network(Role::writer, 7));
  writer->reconcile();
  const PointCloud2 cloud;
  core->publish(&cloud);
  EXPECT_FALSE(writer->take_progress(false));
  reader_listens(200);
  core->publish(&cloud);
  for (int i = 0; i < 3; ++i) {
    const std::optional<Progress> progress = writer->take_progress(false);
    ASSERT_TRUE(progress);
    EXPECT_EQ(*progress, (Progress{.writer = 7, .samples = 2, .bytes = progress->bytes}));
  }
  EXPECT_FALSE(writer->take_progress(false));
}

TEST_F(LocalWriterTest, ItsProgressIsTakenAgainForThoseWhoMayNotHaveHeardIt) {
  open(over_network(Role::writer, 7));
  writer->reconcile();
  reader_listens(200);
  EXPECT_FALSE(writer->take_progress(true)) << "nothing was sent";
  const PointCloud2 cloud;
  core->publish(&cloud);
  while (writer->take_progress(false)) continue;
  EXPECT_TRUE(writer->take_progress(true));
}

TEST_F(LocalWriterTest, HasAnAccountOfEachReaderThatMatches) {
  open(over_network(Role::writer, 7));
  EXPECT_THAT(writer->matching_readers(), IsEmpty());
  reader_listens(200);
  Endpoint other = over_network(Role::reader, 201);
  other.type_hash = 1;
  negotiation.endpoint_seen(other);
  writer->reconcile();
  EXPECT_THAT(writer->matching_readers(), ElementsAre(200));
}

TEST_F(LocalWriterTest, TellsEventsOnceAndOnlyIfSomethingHasHappened) {
  open(over_network(Role::writer, 7));
  reader_listens(200);
  writer->report_events();
  EXPECT_EQ(events.size(), 1U) << "a reader matches";
  const int looks = network_port->looks;
  writer->report_events();
  EXPECT_EQ(events.size(), 1U);
  EXPECT_EQ(network_port->looks, looks) << "no state is compared";
}

TEST_F(LocalWriterTest, ThatSharedMemoryTookNoSampleIsToldWithTheNextLookAndOnce) {
  open_in_memory();
  reader_attaches(200);
  writer->report_events();
  events.clear();
  const PointCloud2 cloud;
  for (int samples = 1; samples <= 2; ++samples) {
    for (int i = 0; i < samples; ++i) EXPECT_EQ(core->publish(&cloud), PublishStatus::no_memory);
    for (int look = 0; look < 3; ++look) writer->report_events();
  }
  ASSERT_EQ(events.size(), 2U);
  for (const Event& event : events) EXPECT_EQ(event.kind, Event::Kind::samples_diverted);
  EXPECT_EQ(events[0].count, 1U);
  EXPECT_EQ(events[1].count, 2U);
}

TEST_F(LocalWriterTest, ItsAccountOfAReaderHasWhatWasDivertedToThatReaderOnly) {
  open_in_memory();
  reader_attaches(200);
  const PointCloud2 cloud;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(core->publish(&cloud), PublishStatus::no_memory);
  EXPECT_EQ(core->diverted().total(), 3U);
  EXPECT_EQ(writer->account_of(200).diverted, 0U) << "it has no route by UDP";
  EXPECT_EQ(writer->account_of(200).dropped, 3U);
}

TEST_F(LocalWriterTest, ThatItMissedItsOwnDeadlineIsToldOnceForEachLookThatFindsIt) {
  Endpoint endpoint = over_network(Role::writer, 7);
  endpoint.qos.deadline = std::chrono::minutes(1);
  open(endpoint);
  writer->reconcile();
  const Time begin = std::chrono::steady_clock::now();
  for (const auto& [minutes, missed] : std::map<int, std::uint64_t>{{1, 1}, {2, 1}, {5, 3}}) {
    events.clear();
    for (int look = 0; look < 3; ++look) {
      writer->watch_promises(begin + std::chrono::minutes(minutes));
      writer->report_events();
    }
    ASSERT_EQ(events.size(), 1U) << minutes;
    EXPECT_EQ(events[0].kind, Event::Kind::deadline_missed);
    EXPECT_EQ(events[0].count, missed);
  }
}

TEST_F(LocalWriterTest, ItsReadersAreToldThatItLivesOnlyIfTheyAskForALease) {
  open(over_network(Role::writer, 7));
  reader_listens(200);
  EXPECT_FALSE(writer->watch_promises(soon()));
  EXPECT_FALSE(writer->pace());
}

TEST_F(LocalWriterTest, EachAssertionOfTheProgramIsSentAtOnceUnlessOneWasJustSent) {
  const auto lease = std::chrono::minutes(3);
  Endpoint endpoint = over_network(Role::writer, 7);
  endpoint.qos.liveliness = manual_by_topic;
  endpoint.qos.liveliness_lease = lease;
  open(endpoint);
  Endpoint asking = over_network(Role::reader, 200);
  asking.qos.liveliness_lease = lease;
  asking.request.listening = {7};
  negotiation.endpoint_seen(asking);
  writer->reconcile();
  Time now = std::chrono::steady_clock::now();
  for (int round = 0; round < 3; ++round, now += lease) {
    const int before = notifications;
    core->assert_liveliness();
    EXPECT_EQ(notifications, before + 1) << "the agent is notified at once";
    EXPECT_TRUE(writer->watch_promises(now)) << "and sends the assertion to the readers";
    for (int i = 0; i < 10; ++i) {
      core->assert_liveliness();
      EXPECT_FALSE(writer->watch_promises(now)) << "one was just sent";
    }
    EXPECT_LE(notifications, before + 2);
    EXPECT_TRUE(writer->watch_promises(now + lease / 2)) << "the last one is not forgotten";
    EXPECT_FALSE(writer->watch_promises(now + lease)) << "nothing new was asserted";
  }
}

}  // namespace
}  // namespace sft::core
