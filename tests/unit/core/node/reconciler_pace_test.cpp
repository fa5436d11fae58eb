// Tests how often a node runs its periodic checks.
#include "tests/unit/core/node/reconciler_fixture.h"

namespace sft::core {
namespace {

TEST_F(ReconcilerTest, ANodeLooksAroundAgainWhenDiscoveryHasToAndSeldomOtherwise) {
  using std::chrono::milliseconds;
  const Time now = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  EXPECT_EQ(reconciler.tick(now), TickPace::pause_when_quiet);
  discovery.next_look = now + milliseconds(42);
  EXPECT_EQ(reconciler.tick(now), milliseconds(42));
  discovery.next_look = now + std::chrono::hours(1);
  EXPECT_EQ(reconciler.tick(now), TickPace::pause_when_quiet);
}

/// The usual checks of a quiet node are rare. With these checks alone, a missed short deadline or lease
/// would be detected late.
TEST_F(ReconcilerTest, ANodeLooksTwiceInADeadlineAndSixTimesInALeaseThatItKeepsAlsoWhenNothingHappens) {
  using std::chrono::milliseconds;
  // These periods need more frequent checks than all other work of the node.
  constexpr milliseconds deadline{80}, lease{240}, requested{60};
  const auto quiet = [&](std::chrono::seconds after) {
    return std::chrono::steady_clock::now() + std::chrono::seconds(10) + after;
  };
  reconciler.tick(quiet(std::chrono::seconds(0)));
  ASSERT_EQ(reconciler.tick(quiet(std::chrono::seconds(0))), TickPace::pause_when_quiet);
  const auto open = [&](EndpointId id, const Qos& qos) {
    PublisherCore::Spec spec{id, "points", &type, 1 << 16};
    spec.qos = qos;
    Endpoint ours = endpoint(Role::writer, id);
    ours.qos = qos;
    reconciler.add_writer(ours, std::make_shared<PublisherCore>(std::move(spec), BufferPool::make(1 << 20),
                                                                std::make_shared<TestWriterPort>()));
    return reconciler.reconcile();
  };
  EXPECT_EQ(open(7, {.deadline = deadline}), deadline / 2) << "at once";
  EXPECT_EQ(reconciler.tick(quiet(std::chrono::seconds(5))), deadline / 2);
  reconciler.remove(7);
  open(8, {.liveliness_lease = lease});
  EXPECT_EQ(reconciler.tick(quiet(std::chrono::seconds(10))), lease / 6);
  reconciler.remove(8);
  const auto port = std::make_shared<TestReaderPort>(connections);
  auto core = std::make_shared<SubscriberCore>(SubscriberCore::Spec{.topic = "points",
                                                                    .type = &type,
                                                                    .feeds = {{.id = 200, .selection = mask}},
                                                                    .options = {},
                                                                    .callback = nullptr},
                                               bells->at(1), nullptr);
  core->ports().set_network(port);
  Endpoint reader = endpoint(Role::reader, 200), writer = endpoint(Role::writer, 9);
  reader.qos.deadline = writer.qos.deadline = requested;
  reconciler.add_reader(reader, {core, port});
  reconciler.tick(quiet(std::chrono::seconds(15)));
  EXPECT_EQ(reconciler.tick(quiet(std::chrono::seconds(20))), TickPace::pause_when_quiet)
      << "no writer keeps the deadline";
  reconciler.take(std::make_shared<const Endpoint>(writer));
  reconciler.reconcile();
  EXPECT_EQ(reconciler.tick(quiet(std::chrono::seconds(30))), requested / 2);
}

}  // namespace
}  // namespace sft::core
