// Each sample that arrives wakes a sleeping reader, and increases the port's count of arrivals.
#include "tests/conformance/conformance.h"
#include "tests/support/test_seed.h"

namespace sft::conformance {
namespace {

using core::SampleHandle;
using core::SendStatus;

/// The writer sends at a random moment after each request, while its reader falls asleep or sleeps.
TEST_P(Conformance, WakesItsReaderForEveryArrival) {
  constexpr std::uint64_t rounds = 5000;
  test::Random random{test::test_seed()};
  SCOPED_TRACE(test::how_to_repeat());
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  std::atomic<std::uint64_t> asked{0};
  const std::jthread publisher([&](const std::stop_token& stop) {
    for (std::uint64_t n = 1; n <= rounds && !stop.stop_requested(); ++n) {
      while (asked < n && !stop.stop_requested()) std::this_thread::yield();
      for (auto spins = random() % 4000; spins > 0; --spins) asm volatile("");
      EXPECT_EQ(writer.publish(10), SendStatus::sent);
    }
  });
  for (std::uint64_t n = 1; n <= rounds; ++n) {
    asked = n;
    ASSERT_EQ(reader.next_sequences(1), numbers(n, n)) << "it sleeps on";
  }
}

TEST_P(Conformance, WakesEachOfSeveralSleepers) {
  Writer writer(stage);
  std::vector<std::unique_ptr<Reader>> readers;
  std::vector<core::Route> routes;
  for (int i = 0; i < 4; ++i) {
    readers.push_back(std::make_unique<Reader>(stage));
    readers.back()->hear(writer);
    routes.push_back(readers.back()->route());
  }
  writer.serve(routes);
  constexpr std::uint64_t samples = 100;
  std::vector<std::jthread> sleepers;
  std::atomic<std::uint64_t> awake{0};
  for (const auto& reader : readers) {
    sleepers.emplace_back([&] {
      for (std::uint64_t n = 1; n <= samples; ++n) {
        EXPECT_EQ(reader->next_sequences(1), numbers(n, n));
        ++awake;
      }
    });
  }
  for (std::uint64_t n = 1; n <= samples; ++n) {
    ASSERT_EQ(writer.publish(), SendStatus::sent);
    ASSERT_TRUE(eventually([&] { return awake == n * readers.size(); }, hang_timeout)) << n;
  }
}

TEST_P(Conformance, TellsOfEveryArrivalTakenOrNotAlsoWhenTheQueueIsFull) {
  Writer writer(stage);
  Reader reader(stage, {.depth = 2});
  writer.serve(reader);
  for (int i = 0; i < 50; ++i) {
    writer.publish_to(reader);
    const std::uint64_t arrivals = reader.port().arrivals(writer.id());
    EXPECT_EQ(reader.port().arrivals(writer.id()), arrivals) << "nothing has arrived";
    if (i % 5 == 4) {
      EXPECT_TRUE(reader.take());
    }
    EXPECT_EQ(reader.port().arrivals(writer.id()), arrivals) << "nothing has arrived";
  }
}

}  // namespace
}  // namespace sft::conformance
