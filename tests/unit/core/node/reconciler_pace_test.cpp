// How often a node looks around, and says that it lives.
#include "tests/unit/core/node/reconciler_fixture.h"

namespace sft::core {
namespace {

TEST_F(ReconcilerTest, ANodeLooksAroundAgainWhenDiscoveryHasToAndSeldomOtherwise) {
  using std::chrono::milliseconds;
  const Time now = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  discovery.calm = true;
  reconciler.tick(now);  // tells that it lives
  EXPECT_EQ(reconciler.tick(now), TickPace::pause_in_calm);
  discovery.next_look = now + milliseconds(42);
  EXPECT_EQ(reconciler.tick(now), milliseconds(42));
  discovery.next_look = now + std::chrono::hours(1);
  EXPECT_EQ(reconciler.tick(now), TickPace::pause_in_calm);
}

TEST_F(ReconcilerTest, ANodeSaysLessOftenThatItLivesInCalmUnlessItTellsMoreThanThat) {
  const auto writer = our_writer(7, std::make_shared<TestWriterPort>());
  Time now = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  const auto signs_in = [&](std::chrono::milliseconds duration) {
    const std::size_t before = discovery.asserted.size();
    for (const Time end = now + duration; now < end;) reconciler.tick(now += std::chrono::milliseconds(50));
    return discovery.asserted.size() - before;
  };
  discovery.calm = true;
  signs_in(std::chrono::seconds(5));
  EXPECT_EQ(signs_in(std::chrono::milliseconds(14'000)), 10U);
  discovery.calm = false;
  signs_in(std::chrono::seconds(2));
  EXPECT_EQ(signs_in(std::chrono::milliseconds(13'000)), 20U);
  discovery.calm = true;
  signs_in(std::chrono::seconds(2));
  reconciler.liveliness_asserted({.node = 66, .writers = {}, .asked_about = {7}}, now);
  EXPECT_GE(signs_in(std::chrono::milliseconds(1950)), 3U) << "somebody asks";
}

TEST_F(ReconcilerTest, ProgressMakesNoSignMoreWhileSamplesFlowAndOneAfterThePublisherHasPaused) {
  const auto writer = our_writer(7, std::make_shared<TestWriterPort>());
  Endpoint reader = endpoint(Role::reader, 200);
  reader.request.listening = {7};
  reconciler.endpoint_seen(reader);
  reconciler.reconcile();
  reconciler.liveliness_asserted({.node = reader.node_id, .writers = {}});  // it is not lost
  discovery.calm = true;
  const PointCloud2 cloud;
  Time now = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  const auto signs_in = [&](std::chrono::milliseconds duration, bool flows) {
    const std::size_t before = discovery.asserted.size();
    for (const Time end = now + duration; now < end;) {
      if (flows) writer->publish(&cloud);
      reconciler.tick(now += std::chrono::milliseconds(50));
    }
    return discovery.asserted.size() - before;
  };
  signs_in(std::chrono::seconds(5), true);
  EXPECT_EQ(signs_in(std::chrono::milliseconds(14'000), true), 10U);
  EXPECT_EQ(discovery.asserted.back().progress.size(), 1U) << "it goes with the signs that are given anyway";
  const std::uint64_t published = writer->status().published;
  EXPECT_EQ(signs_in(std::chrono::milliseconds(1000), false), 1U);
  ASSERT_EQ(discovery.asserted.back().progress.size(), 1U);
  EXPECT_EQ(discovery.asserted.back().progress[0].samples, published);
  EXPECT_EQ(signs_in(std::chrono::milliseconds(14'000), false), 10U) << "that was told";
}

}  // namespace
}  // namespace sft::core
