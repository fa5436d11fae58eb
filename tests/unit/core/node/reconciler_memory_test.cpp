// Tests of the reconciler when shared memory becomes available or is lost.
#include "tests/unit/core/node/reconciler_fixture.h"
#include "tests/unit/core/node/test_memory.h"

namespace sft::core {
namespace {

/// Shared memory that does not become available.
class AbsentMemory final : public IdleSharedMemory {
 public:
  Availability poll(Time) override { return availability; }
  std::string description() const override { return state; }
  Availability availability = Availability::starting;
  std::string state = "starting";
};

/// One node whose endpoints use shared memory only.
class ReconcilerInMemoryTest : public ReconcilerTest {
 protected:
  Endpoint here(Role role, EndpointId id) const {
    Endpoint e = endpoint(role, id);
    e.network = 1;
    e.may_use_network = false;
    e.may_use_memory = true;
    e.addresses.clear();
    e.host = memory.host_token();
    e.qos = {.durability = transient_local, .history_depth = 3};
    return e;
  }
  std::shared_ptr<SubscriberCore> our_core(EndpointId id) {
    return std::make_shared<SubscriberCore>(SubscriberCore::Spec{.topic = "points",
                                                                 .type = &type,
                                                                 .feeds = {{.id = id, .selection = mask}},
                                                                 .options = {},
                                                                 .callback = nullptr},
                                            bells->at(1), nullptr);
  }
  void open_reader(EndpointId id, Reliability reliability = Reliability::best_effort) {
    Endpoint reader = here(Role::reader, id);
    reader.qos.reliability = reliability;
    node.add_reader(reader, {our_core(id), nullptr});
    node.tick();
  }
  std::shared_ptr<PublisherCore> open_writer(EndpointId id) {
    auto core = std::make_shared<PublisherCore>(PublisherCore::Spec{id, "points", &type, 1 << 16},
                                                BufferPool::make(1 << 20), nullptr);
    node.add_writer(here(Role::writer, id), core);
    node.tick();
    return core;
  }

  TestMemory memory;
  Reconciler node{1, &memory, nullptr, discovery, dispatcher, log};
};

TEST_F(ReconcilerInMemoryTest, PublishersThatAreMadeUpTakeFewPortsAndGiveThemBackWhenTheyAreLost) {
  open_reader(200);
  memory.attaches = false;
  const auto seen = [&](EndpointId id) {
    Endpoint writer = here(Role::writer, id);
    writer.node_id = id;
    node.take(std::make_shared<const Endpoint>(writer));
    node.reconcile();
  };
  for (EndpointId id = 1000; id < 1200; ++id) seen(id);
  EXPECT_EQ(memory.connections.size(), 128U);
  seen(7);
  EXPECT_FALSE(memory.connections.contains(7)) << "none is left";
  for (EndpointId id = 1000; id < 1200; ++id) node.take(EndpointLost{id});
  node.reconcile();
  EXPECT_TRUE(test::eventually([&] {
    node.tick();
    return memory.connections == std::set<EndpointId>{7};
  }));
}

TEST_F(ReconcilerInMemoryTest, ConnectionsThatAreMadeTogetherAreLimitedUntilTheirPublishersShowUp) {
  const auto see_many = [&] {
    for (EndpointId id = 1000; id < 1200; ++id) {
      Endpoint writer = here(Role::writer, id);
      writer.node_id = id;
      node.take(std::make_shared<const Endpoint>(writer));
    }
    node.reconcile();
  };
  open_reader(200);
  memory.attaches = false;
  see_many();
  EXPECT_EQ(memory.connections.size(), 128U);
  memory.attaches = true;
  Endpoint one_more = here(Role::writer, 7);
  one_more.node_id = 7;
  node.take(std::make_shared<const Endpoint>(one_more));
  node.reconcile();
  EXPECT_TRUE(memory.connections.contains(7)) << "those have shown up";
}

TEST_F(ReconcilerInMemoryTest, AReaderLetsGoOfAPublisherThatWent) {
  open_reader(200);
  node.take(std::make_shared<const Endpoint>(here(Role::writer, 7)));
  node.take(std::make_shared<const Endpoint>(here(Role::writer, 8)));
  node.tick();
  EXPECT_THAT(memory.connections, ElementsAre(7, 8));
  node.take(EndpointDeparted{7});
  node.tick();
  EXPECT_THAT(memory.connections, ElementsAre(8));
}

// A queue for which the publisher waits is of another kind. A best-effort publisher waits for no reader.
TEST_F(ReconcilerInMemoryTest, AReaderConnectsAnewWhereItsPublisherBeginsToWaitAndIsReliable) {
  for (const auto kind : {Reliability::best_effort, Reliability::reliable}) {
    open_reader(kind == Reliability::reliable ? 201 : 200, kind);
    const EndpointId id = kind == Reliability::reliable ? 8 : 7;
    Endpoint writer = here(Role::writer, id);
    writer.qos.reliability = kind;
    node.take(std::make_shared<const Endpoint>(writer));
    node.reconcile();
    memory.asked_for.clear();
    writer.waits = true;
    node.take(std::make_shared<const Endpoint>(writer));
    node.reconcile();
    EXPECT_THAT(memory.connections, ::testing::Contains(id));
    EXPECT_EQ(memory.asked_for.size(), kind == Reliability::reliable ? 1U : 0U);
  }
}

TEST_F(ReconcilerInMemoryTest, ADaemonThatDoesNotAnswerIsNotAskedForOthersAtOnceAndOneThatRefusesIs) {
  for (const Errc refusal : {Errc::unavailable, Errc::limit_exceeded}) {
    std::vector<std::string> lines;
    NodeLog own_log("node", LogLevel::warning,
                    [&](LogLevel, std::string_view line) { lines.emplace_back(line); });
    Reconciler own(1, &memory, nullptr, discovery, dispatcher, own_log);
    memory.asked_for.clear();
    memory.refusal = refusal;
    const auto begin = std::chrono::steady_clock::now();
    own.add_reader(here(Role::reader, 200), {our_core(200), nullptr});
    own.tick();
    own.take(std::make_shared<const Endpoint>(here(Role::writer, 7)));
    own.reconcile();
    own.take(std::make_shared<const Endpoint>(here(Role::writer, 8)));
    own.reconcile();
    if (std::chrono::steady_clock::now() - begin >= Retry::pause_min) GTEST_SKIP() << "it took too long";
    if (refusal == Errc::unavailable) {
      EXPECT_THAT(memory.asked_for, ElementsAre(7));
    } else {
      EXPECT_THAT(memory.asked_for, ElementsAre(7, 8)) << "of each once";
    }
    EXPECT_EQ(lines.size(), 1U) << "the reason is the same for each";
  }
}

TEST_F(ReconcilerInMemoryTest, AReaderSaysThatTheHistoryHasBegunOnceItComesThroughMemory) {
  open_reader(200);
  node.take(std::make_shared<const Endpoint>(here(Role::writer, 7)));
  node.tick();
  EXPECT_THAT(discovery.sent.back().attached, ElementsAre(7));
  EXPECT_THAT(discovery.sent.back().begun, IsEmpty());
  memory.progress = HistoryProgress::came;
  node.tick();
  EXPECT_THAT(discovery.sent.back().begun, ElementsAre(7));
}

TEST_F(ReconcilerInMemoryTest, ConnectionsAreLookedAfterOftenAsLongAsSamplesComeByThem) {
  open_reader(200);
  const Endpoint writer = here(Role::writer, 7);
  node.take(std::make_shared<const Endpoint>(writer));
  memory.progress = HistoryProgress::came;
  Time now = std::chrono::steady_clock::now();
  node.tick(now += std::chrono::seconds(10));
  ASSERT_THAT(discovery.sent.back().attached, ElementsAre(7));
  EXPECT_EQ(node.tick(now += std::chrono::seconds(2)), TickPace::pause_when_quiet) << "everybody is asleep";
  for (int i = 0; i < 3; ++i) {
    ++memory.arrivals;
    EXPECT_EQ(node.tick(now += std::chrono::milliseconds(50)), TickPace::pause);
  }
  EXPECT_EQ(node.tick(now += std::chrono::seconds(2)), TickPace::pause_when_quiet);
}

TEST_F(ReconcilerInMemoryTest, ConnectionsAreLookedAfterOftenAsSoonAsALookFindsThatSamplesWent) {
  const auto publisher = open_writer(7);
  Endpoint reader = here(Role::reader, 200);
  reader.qos.durability = Durability::volatile_;
  reader.request.attached = {7};
  node.take(std::make_shared<const Endpoint>(reader));
  Time now = std::chrono::steady_clock::now();
  node.tick(now += std::chrono::seconds(10));
  ASSERT_FALSE(memory.routes.empty());
  EXPECT_EQ(node.tick(now += std::chrono::seconds(2)), TickPace::pause_when_quiet) << "everybody is asleep";
  const PointCloud2 cloud;
  publisher->publish(&cloud);
  EXPECT_EQ(node.tick(now += std::chrono::milliseconds(100)), TickPace::pause);
}

TEST_F(ReconcilerInMemoryTest, AWriterLetsGoOfItsPortWhenTheDaemonIsAnotherOne) {
  memory.attaches = false;
  node.tick();
  open_reader(200);
  open_writer(7);
  EXPECT_EQ(memory.writers, 1);
  memory.daemon = 2;
  memory.is_full = true;
  node.tick();
  EXPECT_EQ(memory.writers, 0) << "although nothing else is to be served than before";
}

TEST_F(ReconcilerTest, TheLogSaysWhySharedMemoryDoesNotComeUp) {
  AbsentMemory memory;
  std::vector<std::string> lines;
  NodeLog all("node", LogLevel::info, [&](LogLevel level, std::string_view text) {
    lines.push_back((level == LogLevel::warning ? "warning " : "info ") + std::string(text));
  });
  Reconciler own(1, &memory, &network, discovery, dispatcher, all);
  const auto becomes = [&](Availability availability, const std::string& state) {
    memory.availability = availability;
    memory.state = state;
    own.tick();
    own.tick();
  };
  becomes(Availability::starting, "starts sftd");
  becomes(Availability::unavailable, "sftd could not be started");
  becomes(Availability::starting, "starts sftd");
  becomes(Availability::unavailable, "sftd could not be started");
  becomes(Availability::unavailable, "/dev/shm is too small");
  EXPECT_THAT(lines, ElementsAre("info node: shared memory: starts sftd",
                                 "warning node: shared memory: sftd could not be started",
                                 "info node: shared memory: /dev/shm is too small"));
}

}  // namespace
}  // namespace sft::core
